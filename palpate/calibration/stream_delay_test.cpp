#include "palpate/calibration/stream_delay.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <numbers>

#include "palpate/core/random.h"
#include "palpate/math/random_vector.h"
#include "tests/chi_square.h"

namespace palpate::calibration {
namespace {

Vector3 path(double t) {
  return {0.1 * std::sin(2.1 * t), 0.08 * std::sin(3.3 * t + 1), 0.07 * std::cos(2.7 * t)};
}

std::vector<TimedPoint> early_stream() {
  std::vector<TimedPoint> stream;
  for (int i = 0; i < 8000; ++i) stream.push_back({i * 1e-3, path(i * 1e-3)});
  return stream;
}

std::vector<TimedPoint> late_stream(double delay, double noise, Random& random, double outliers = 0.0) {
  std::vector<TimedPoint> stream;
  for (int i = 0; i < 700; ++i) {
    const double t = 0.5 + i * 0.01;
    Vector3 p = path(t - delay) + Vector3(1e-3, -2e-3, 0.5e-3);
    p += noise * Vector3(random.normal(), random.normal(), random.normal());
    if (random.chance(outliers)) p.x() += 0.02;
    stream.push_back({t, p});
  }
  return stream;
}

TEST(StreamDelayStatistics, FindsTheDelayWithinItsStatedError) {
  double chi2 = 0.0;
  const int runs = 200;
  for (int run = 0; run < runs; ++run) {
    Random random(static_cast<std::uint64_t>(run));
    const double delay = random.uniform(-0.2, 0.2);
    const auto found = estimate_stream_delay(early_stream(), late_stream(delay, 1e-4, random));
    ASSERT_TRUE(found.has_value());
    EXPECT_LT(found->standard_deviation(0), 3e-5);
    EXPECT_NEAR(found->value.offset.x(), 1e-3, 1e-4);
    chi2 += std::pow((found->value.delay_s - delay) / found->standard_deviation(0), 2);
  }
  EXPECT_TRUE(tests::is_chi_square(chi2, runs));
}

TEST(StreamDelay, FivePercentOutliersDoNotMatter) {
  Random random(5);
  const auto found = estimate_stream_delay(early_stream(), late_stream(0.0123, 1e-4, random, 0.05));
  ASSERT_TRUE(found.has_value());
  EXPECT_NEAR(found->value.delay_s, 0.0123, 2e-4);
}

TEST(StreamDelay, RefusesAPointThatHardlyMovesAndStreamsThatDoNotMeet) {
  Random random(6);
  auto still = early_stream();
  for (auto& p : still) p.place *= 0.01;
  auto late = late_stream(0.0, 1e-4, random);
  for (auto& p : late) p.place *= 0.01;
  const auto refused_still = estimate_stream_delay(still, late);
  ASSERT_FALSE(refused_still.has_value());
  EXPECT_NE(refused_still.error().message.find("move it faster"), std::string::npos);
  for (auto& p : late) p.time_s += 100.0;
  EXPECT_FALSE(estimate_stream_delay(early_stream(), late).has_value());
}

// A smooth error of places: waves of random directions, correlated by exp(-d^2 / (2 L^2)).
class FieldOfPlaces {
 public:
  FieldOfPlaces(Random& random, double sd, double correlation) : size_(sd * std::sqrt(2.0 / kWaves)) {
    for (auto& of_axis : waves_)
      for (auto& wave : of_axis) {
        wave.number = normal3(random) / correlation;
        wave.phase = random.uniform(0.0, 2.0 * std::numbers::pi);
      }
  }
  Vector3 at(const Vector3& place) const {
    Vector3 error;
    for (int axis = 0; axis < 3; ++axis) {
      double sum = 0.0;
      for (const auto& wave : waves_[static_cast<std::size_t>(axis)])
        sum += std::cos(wave.number.dot(place) + wave.phase);
      error[axis] = size_ * sum;
    }
    return error;
  }

 private:
  static constexpr int kWaves = 60;
  struct Wave {
    Vector3 number = Vector3::Zero();
    double phase = 0.0;
  };
  double size_;
  std::array<std::array<Wave, kWaves>, 3> waves_;
};

TEST(StreamDelayStatistics, WhatASystematicErrorPassesForIsAsLargeAsStated) {
  constexpr int kRuns = 100;
  constexpr double kSystematic = 1e-4;
  double squares = 0.0;
  const auto early = early_stream();
  const double stated = delay_of_systematic(early, kSystematic);
  for (int run = 0; run < kRuns; ++run) {
    Random random(static_cast<std::uint64_t>(run));
    const FieldOfPlaces field(random, kSystematic, kSystematicReach);
    auto late = late_stream(0.0, 0.0, random);
    for (auto& p : late) p.place += field.at(p.place);
    const auto found = estimate_stream_delay(early, late);
    ASSERT_TRUE(found.has_value());
    squares += found->value.delay_s * found->value.delay_s;
  }
  EXPECT_TRUE(tests::is_chi_square(squares / (stated * stated), kRuns)) << stated;
  EXPECT_GT(stated, 1e-5);
}

TEST(StreamDelay, APointThatStandsIsToldNoDelayOfASystematicError) {
  EXPECT_EQ(delay_of_systematic({}, 1e-4), 0.0);
  std::vector<TimedPoint> standing;
  for (int i = 0; i < 100; ++i) standing.push_back({0.01 * i, Vector3(1.0, 2.0, 3.0)});
  EXPECT_EQ(delay_of_systematic(standing, 1e-4), 0.0);
}

}  // namespace
}  // namespace palpate::calibration
