#include "palpate/calibration/stream_delay.h"

#include <gtest/gtest.h>

#include <cmath>

#include "palpate/core/random.h"
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

}  // namespace
}  // namespace palpate::calibration
