#include "palpate/evaluation/timecode_log.h"

#include <gtest/gtest.h>

#include <cmath>

#include "palpate/core/random.h"

namespace palpate::evaluation {
namespace {

Instant<GraphicsClock> ms_at(double x) { return Instant<GraphicsClock>::from_seconds(1e-3 * x); }

struct Change {
  double ms;    // when
  double code;  // ms, what
};

// What a camera sees, by summing up a thousand moments of the exposure.
device::TimecodeBits seen_by_a_camera(const std::vector<Change>& changes, double middle_ms,
                                      double exposure_ms) {
  device::TimecodeBits sum{};
  constexpr int kMoments = 4000;
  for (int i = 0; i < kMoments; ++i) {
    const double t = middle_ms + exposure_ms * ((i + 0.5) / kMoments - 0.5);
    const Change* held = &changes.front();
    for (const auto& change : changes)
      if (change.ms <= t) held = &change;
    const auto light = device::timecode_light(seconds(1e-3 * held->code), Duration(0));
    for (std::size_t k = 0; k < sum.size(); ++k) sum[k] += light[k + 2] / kMoments;
  }
  return sum;
}

TimecodeLog log_of(const std::vector<Change>& changes) {
  TimecodeLog log;
  for (const auto& change : changes) log.show(ms_at(change.ms), seconds(1e-3 * change.code));
  return log;
}

// A screen on which somebody draws when they can: mostly each millisecond, with gaps of a picture's work.
std::vector<Change> screen_of(Random& random) {
  std::vector<Change> changes;
  for (double t = 5000.0; t < 6000.0;) {
    changes.push_back({t, t + 0.2});
    t += random.chance(0.03) ? random.uniform(5.0, 20.0) : random.uniform(0.9, 1.3);
  }
  return changes;
}

TEST(TimecodeLog, FindsTheMomentOfAnImageThroughGapsExposureAndNoise) {
  Random random(1, "strip log");
  for (const double exposure : {0.5, 4.0, 8.0, 16.0, 30.0}) {
    double worst = 0.0;
    for (int run = 0; run < 20; ++run) {
      const auto changes = screen_of(random);
      const double middle = random.uniform(5100.0, 5950.0);
      auto seen = seen_by_a_camera(changes, middle, exposure);
      for (auto& bit : seen) bit += random.normal(0.01);
      const auto moment = log_of(changes).find(seen, seconds(1e-3 * exposure), ms_at(6000));
      ASSERT_TRUE(moment) << moment.error().message;
      const double off = 1e3 * std::abs(to_seconds(moment->middle - ms_at(middle)));
      worst = std::max(worst, off - 1e3 * to_seconds(moment->unsure));
    }
    // Beyond what it says of itself: 1 % of a block that takes a whole exposure to change, and a few of
    // those.
    EXPECT_LT(worst, 0.3 + 0.02 * exposure) << exposure << " ms";
  }
}

TEST(TimecodeLog, OnAScreenThatHoldsItsPictureAnImageBetweenTwoChangesFitsAWholeSpan) {
  std::vector<Change> changes;
  for (int i = 0; i < 60; ++i) changes.push_back({5000 + 1000.0 / 60 * i, 5000 + 1000.0 / 60 * i});
  const auto log = log_of(changes);
  // Exposed for 8 ms, beginning 2 ms after a change: from 0 to 16.67 - 8 ms after it all looks the same.
  const double change = 5000 + 1000.0 / 60 * 30;
  const auto held = log.find(seen_by_a_camera(changes, change + 6.0, 8.0), seconds(8e-3), ms_at(6000));
  ASSERT_TRUE(held);
  EXPECT_NEAR(1e3 * to_seconds(held->unsure), 0.5 * (1000.0 / 60 - 8.0), 0.1);
  EXPECT_NEAR(1e3 * to_seconds(held->middle - ms_at(change)), 0.5 * 1000.0 / 60, 0.1);
  // A change within the exposure says when.
  const auto sharp = log.find(seen_by_a_camera(changes, change + 1.5, 8.0), seconds(8e-3), ms_at(6000));
  ASSERT_TRUE(sharp);
  EXPECT_NEAR(1e3 * to_seconds(sharp->middle - ms_at(change)), 1.5, 0.05);
  EXPECT_LT(1e3 * to_seconds(sharp->unsure), 0.1);
}

TEST(TimecodeLog, IsNotFooledByTheOldTimecodeOfFourSecondsAgo) {
  TimecodeLog log;
  for (int ms = 1000; ms < 9000; ++ms) log.show(ms_at(ms), std::chrono::milliseconds(ms));
  device::TimecodeBits seen{};
  const auto light = device::timecode_light(std::chrono::milliseconds(8904), std::chrono::milliseconds(8));
  std::copy_n(light.begin() + 2, seen.size(), seen.begin());
  const auto moment = log.find(seen, std::chrono::milliseconds(8), ms_at(9000));
  ASSERT_TRUE(moment);
  EXPECT_NEAR(moment->middle.seconds(), 8.904, 2e-4);
}

TEST(TimecodeLog, WhatItNeverShowedIsRefusedWithTheReason) {
  TimecodeLog log;
  EXPECT_NE(log.find({}, Duration(0), ms_at(1)).error().message.find("nothing was shown"), std::string::npos);
  for (int ms = 0; ms < 500; ++ms) log.show(ms_at(ms), std::chrono::milliseconds(ms));
  device::TimecodeBits wrong;
  wrong.fill(0.5);
  const auto refusal = log.find(wrong, std::chrono::milliseconds(1), ms_at(500));
  ASSERT_FALSE(refusal);
  EXPECT_NE(refusal.error().message.find("hides it"), std::string::npos) << refusal.error().message;
}

}  // namespace
}  // namespace palpate::evaluation
