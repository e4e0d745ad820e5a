#include "palpate/time/clock_history.h"

#include <gtest/gtest.h>

#include "palpate/core/random.h"

namespace palpate::inline time {
namespace {

constexpr double kLatency = 0.004, kRate = 60.0;

// A clock whose drift changes slowly, as with its temperature.
double device_time(double t) { return 500.0 + t + 30e-6 * t + 20e-6 * 40.0 * std::sin(t / 40.0); }

TEST(ClockHistory, FollowsAClockWhoseDriftChangesOverMinutes) {
  ClockHistory<TrackerClock, PhysicsClock> history;
  ClockEstimator<TrackerClock, PhysicsClock> newest;
  Random random(3, "clock history");
  constexpr double kSeconds = 180.0;
  for (double t = 0.0; t < kSeconds; t += 1.0 / kRate) {
    const auto stamp = Instant<TrackerClock>::from_seconds(device_time(t));
    const auto received = Instant<PhysicsClock>::from_seconds(t + kLatency + random.uniform(0.0, 0.002));
    history.add(stamp, received);
    newest.add(stamp, received);
  }
  double worst = 0.0, worst_newest = 0.0;
  for (double t = 0.0; t < kSeconds; t += 0.1) {
    const auto stamp = Instant<TrackerClock>::from_seconds(device_time(t));
    worst = std::max(worst, std::abs(history.to(stamp).seconds() - t - kLatency));
    worst_newest = std::max(worst_newest, std::abs(newest.model().to(stamp).seconds() - t - kLatency));
  }
  EXPECT_LT(worst, 0.4e-3);
  EXPECT_GT(worst_newest, 1e-3) << "the last twelve seconds alone would do";
}

TEST(ClockHistory, MakesNoStepsAndRunsForward) {
  ClockHistory<TrackerClock, PhysicsClock> history;
  Random random(4, "clock history");
  for (double t = 0.0; t < 60.0; t += 1.0 / kRate)
    history.add(Instant<TrackerClock>::from_seconds(device_time(t)),
                Instant<PhysicsClock>::from_seconds(t + kLatency + random.uniform(0.0, 0.002)));
  double last = history.to(Instant<TrackerClock>::from_seconds(device_time(-0.01))).seconds();
  for (double t = 0.0; t < 60.0; t += 0.01) {
    const double now = history.to(Instant<TrackerClock>::from_seconds(device_time(t))).seconds();
    EXPECT_NEAR(now - last, 0.01, 20e-6) << t;
    last = now;
  }
}

TEST(ClockHistory, AClockThatWasSetBackIsReadAnew) {
  ClockHistory<TrackerClock, PhysicsClock> history;
  const auto run = [&](double stamp, double host) {
    for (double t = 0.0; t < 30.0; t += 1.0 / kRate)
      history.add(Instant<TrackerClock>::from_seconds(stamp + t),
                  Instant<PhysicsClock>::from_seconds(host + t));
  };
  run(100.0, 0.0);
  run(90.0, 40.0);
  EXPECT_EQ(history.restarts(), 1);
  EXPECT_NEAR(history.to(Instant<TrackerClock>::from_seconds(115.0)).seconds(), 65.0, 1e-3);
}

}  // namespace
}  // namespace palpate::inline time
