#include "palpate/server/graphics/frame_pace.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "palpate/core/random.h"

namespace palpate::server::graphics {
namespace {

Instant<GraphicsClock> at_ms(double ms) {
  return Instant<GraphicsClock>{
      std::chrono::duration_cast<Duration>(std::chrono::duration<double, std::milli>(ms))};
}
double ms_of(Duration d) { return 1e3 * to_seconds(d); }

constexpr double kPeriod = 100.0 / 3.0;  // ms

// Pictures that take so long to draw, from an image that arrives 37 ms after its exposure: when each is due, ms.
std::vector<double> due_times(FramePace& pace, const std::vector<double>& drawing_ms) {
  std::vector<double> due;
  for (std::size_t i = 0; i < drawing_ms.size(); ++i) {
    const double taken = kPeriod * static_cast<double>(i);
    due.push_back(ms_of(pace.due(at_ms(taken), at_ms(taken + 37.0 + drawing_ms[i])).since_epoch));
  }
  return due;
}

// The share of intervals within a millisecond of the camera's, after the first two seconds.
double even(const std::vector<double>& times) {
  int good = 0, all = 0;
  for (std::size_t i = 64; i < times.size(); ++i, ++all)
    if (std::abs(times[i] - times[i - 1] - kPeriod) < 1.0) ++good;
  return static_cast<double>(good) / all;
}

TEST(FramePace, PicturesThatTakeUnequallyLongComeEvenly) {
  Random random(1, "pace");
  std::vector<double> drawing, at_once;
  for (int i = 0; i < 600; ++i) drawing.push_back(8.0 + 5.0 * random.uniform());
  for (std::size_t i = 0; i < drawing.size(); ++i)
    at_once.push_back(kPeriod * static_cast<double>(i) + 37.0 + drawing[i]);
  FramePace pace;
  const auto due = due_times(pace, drawing);
  EXPECT_LT(even(at_once), 0.5);
  EXPECT_GT(even(due), 0.9);
  double held = 0.0;
  for (std::size_t i = 0; i < due.size(); ++i) {
    EXPECT_GE(due[i], at_once[i] - 1e-6) << "before it is ready";
    held += (due[i] - at_once[i]) / static_cast<double>(due.size());
  }
  EXPECT_LT(held, 2.5) << "half of what drawing differs by";
}

TEST(FramePace, PicturesThatTakeEquallyLongAreNotHeld) {
  FramePace pace;
  const auto due = due_times(pace, std::vector<double>(100, 9.0));
  for (std::size_t i = 0; i < due.size(); ++i)
    EXPECT_NEAR(due[i], kPeriod * static_cast<double>(i) + 46.0, 1e-3);
  EXPECT_NEAR(ms_of(*pace.age()), 46.0, 1e-3);
}

TEST(FramePace, NothingIsHeldBeforeItIsKnownHowLongPicturesTake) {
  FramePace pace;
  std::vector<double> drawing(FramePace::kFewest, 5.0);
  drawing.front() = 300.0;  // a shader that is compiled
  const auto due = due_times(pace, drawing);
  for (std::size_t i = 0; i < due.size(); ++i)
    EXPECT_NEAR(due[i], kPeriod * static_cast<double>(i) + 37.0 + drawing[i], 1e-3);
}

// One picture in six takes far longer: the others do not wait for it.
TEST(FramePace, AHoldIsBounded) {
  std::vector<double> drawing;
  for (int i = 0; i < 300; ++i) drawing.push_back(i % 6 == 0 ? 40.0 : 8.0);
  FramePace pace;
  const auto due = due_times(pace, drawing);
  for (std::size_t i = 64; i < due.size(); ++i) {
    const double ready = kPeriod * static_cast<double>(i) + 37.0 + drawing[i];
    EXPECT_LE(due[i] - ready, ms_of(FramePace::kBeyondMedian) + 1e-3);
    if (i % 6 == 0) EXPECT_NEAR(due[i], ready, 1e-3) << "late already";
  }
}

TEST(FramePace, AClockThatJumpsHoldsNothingForLong) {
  FramePace pace;
  due_times(pace, std::vector<double>(100, 9.0));
  const auto ready = at_ms(5000.0);
  EXPECT_EQ(pace.due(at_ms(90'000.0), ready), ready + FramePace::kLongestHold);
  EXPECT_EQ(pace.due(at_ms(-90'000.0), ready), ready);
}

TEST(FramePace, ItFollowsPicturesThatBecomeDearer) {
  std::vector<double> drawing(200, 5.0);
  drawing.resize(400, 12.0);
  FramePace pace;
  const auto due = due_times(pace, drawing);
  EXPECT_NEAR(due.back(), kPeriod * 399.0 + 49.0, 1e-3);
  std::vector<double> cheaper(100, 5.0);
  EXPECT_NEAR(due_times(pace, cheaper).back(), kPeriod * 99.0 + 42.0, 1e-3);
}

}  // namespace
}  // namespace palpate::server::graphics
