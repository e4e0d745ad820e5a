#include "palpate/calibration/internal/smooth_stream.h"

#include <gtest/gtest.h>

#include <cmath>

#include "palpate/core/random.h"

namespace palpate::calibration {
namespace {

TEST(SmoothStream, ACubicIsReadExactlyAtIrregularTimes) {
  Random random(1);
  std::vector<double> time_s;
  for (int i = 0; i < 60; ++i) time_s.push_back(0.1 * i + 0.06 * random.uniform());
  const auto cubic = [](double t) { return 1.0 - 2.0 * t + 0.5 * t * t - 0.1 * t * t * t; };
  Eigen::MatrixXd channels(60, 1);
  for (Eigen::Index i = 0; i < 60; ++i) channels(i, 0) = cubic(time_s[static_cast<std::size_t>(i)]);
  const SmoothStream stream(time_s, channels);
  Eigen::RowVectorXd value, slope;
  for (double t = 0.5; t < 5.5; t += 0.013) {
    ASSERT_TRUE(stream.at(t, value, slope)) << t;
    EXPECT_NEAR(value[0], cubic(t), 1e-9);
    EXPECT_NEAR(slope[0], -2.0 + t - 0.3 * t * t, 1e-8);
  }
}

TEST(SmoothStream, NoiseIsAlikeEverywhereBetweenSamplesAndValueAndSlopeShareNone) {
  // Channel j has a one at sample j alone: the value's channels are the weights of the samples.
  std::vector<double> time_s;
  for (int i = 0; i < 40; ++i) time_s.push_back(0.01 * i);
  const SmoothStream stream(time_s, Eigen::MatrixXd::Identity(40, 40));
  Eigen::RowVectorXd value, slope;
  ASSERT_TRUE(stream.at(0.2, value, slope));
  const double at_sample = value.squaredNorm();
  for (double part = 0.0; part < 1.0; part += 0.1) {
    ASSERT_TRUE(stream.at(0.2 + 0.01 * part, value, slope));
    EXPECT_NEAR(value.squaredNorm() / at_sample, 1.0, 0.03) << part;
    EXPECT_NEAR(value.dot(slope) / (value.norm() * slope.norm()), 0.0, 0.02) << part;
  }
}

TEST(SmoothStream, NothingIsReadInGapsAndBeyondTheEnds) {
  std::vector<double> time_s;
  for (int i = 0; i < 100; ++i)
    if (i < 40 || i > 60) time_s.push_back(0.01 * i);
  const auto n = static_cast<Eigen::Index>(time_s.size());
  const SmoothStream stream(time_s, Eigen::MatrixXd::Ones(n, 1));
  Eigen::RowVectorXd value, slope;
  for (const double t : {-0.1, 0.001, 0.5, 0.985, 1.2}) EXPECT_FALSE(stream.at(t, value, slope)) << t;
  for (const double t : {0.03, 0.38, 0.62, 0.95}) EXPECT_TRUE(stream.at(t, value, slope)) << t;
}

}  // namespace
}  // namespace palpate::calibration
