#include "palpate/calibration/internal/long_run_variance.h"

#include <gtest/gtest.h>

#include <cmath>

#include "palpate/core/random.h"

namespace palpate::calibration {
namespace {

// First-order autoregression of variance 1.
Eigen::VectorXd series(Eigen::Index n, double kept, std::uint64_t seed) {
  Random random(seed);
  Eigen::VectorXd e(n);
  e[0] = random.normal();
  for (Eigen::Index i = 1; i < n; ++i)
    e[i] = kept * e[i - 1] + std::sqrt(1.0 - kept * kept) * random.normal();
  return e;
}

TEST(LongRunVariance, AnAutoregressionIsFound) {
  const auto noise = fit_autoregression(series(20000, 0.8, 1), 20);
  ASSERT_GE(noise.coefficient.size(), 1);
  EXPECT_NEAR(noise.coefficient[0], 0.8, 0.03);
  EXPECT_NEAR(noise.white_variance, 0.36, 0.02);
  EXPECT_NEAR(memory_of(noise, 1.0), 4.0, 1.0);  // 0.8 / (1 - 0.8)
}

TEST(LongRunVariance, ASumsVarianceIsThatOfTheClosedForm) {
  const Autoregression noise{Eigen::VectorXd::Constant(1, 0.8), 0.36};
  Eigen::VectorXd weights(200);
  for (Eigen::Index i = 0; i < 200; ++i) weights[i] = std::sin(0.1 * static_cast<double>(i));
  double expected = 0.0;
  for (Eigen::Index i = 0; i < 200; ++i)
    for (Eigen::Index j = 0; j < 200; ++j)
      expected += weights[i] * weights[j] * std::pow(0.8, std::abs(static_cast<double>(i - j)));
  EXPECT_NEAR(variance_of_sum(noise, weights) / expected, 1.0, 1e-9);
  EXPECT_NEAR(variance_of_sum({{}, 2.0}, weights), 2.0 * weights.squaredNorm(), 1e-12);
}

TEST(LongRunVariance, BartlettsWeightsFallToTheReach) {
  const Eigen::VectorXd ones = Eigen::VectorXd::Ones(4);
  EXPECT_DOUBLE_EQ(bartlett_sum(ones, 0), 4.0);
  EXPECT_DOUBLE_EQ(bartlett_sum(ones, 1), 4.0 + 2.0 * 0.5 * 3.0);
}

}  // namespace
}  // namespace palpate::calibration
