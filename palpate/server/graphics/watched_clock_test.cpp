#include "palpate/server/graphics/watched_clock.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <functional>

#include "palpate/core/random.h"

namespace palpate::server::graphics {
namespace {

// A device of 100 Hz whose samples arrive after 5 to 8 ms, and `late_s` more; its clock is `ahead_s` ahead.
struct Arrivals {
  std::function<double(double t)> ahead_s = [](double) { return 3.0; };
  std::function<double(double t)> late_s = [](double) { return 0.0; };
};

struct Seen {
  int times_set = 0, doubted = 0;
  double set_at = 0.0;      // s, true time
  double last_error = 0.0;  // s, of the newest known moment, beyond the least delay
};

Seen watch(const Arrivals& arrivals, double until = 8.0) {
  WatchedClock<TrackerClock> clock;
  Random random(1, "arrivals");
  Seen seen;
  for (int i = 0; i < static_cast<int>(100.0 * until); ++i) {
    const double t = 0.01 * i;
    const Instant<TrackerClock> stamp{seconds(t + arrivals.ahead_s(t))};
    const double arrived = t + 0.005 + random.uniform(0.0, 0.003) + arrivals.late_s(t);
    const auto time = clock.take(stamp, Instant<GraphicsClock>{seconds(arrived)}, Duration(0));
    if (clock.found_set()) ++seen.times_set, seen.set_at = arrived;
    if (!time)
      ++seen.doubted;
    else
      seen.last_error = to_seconds(time->since_epoch) - (t + 0.005);
  }
  return seen;
}

TEST(WatchedClock, FindsNothingInAClockThatRuns) {
  const auto seen = watch({});
  EXPECT_EQ(seen.times_set, 0);
  EXPECT_EQ(seen.doubted, 0);
  EXPECT_NEAR(seen.last_error, 0.0, 0.003);  // of the delay only the least is known
}

TEST(WatchedClock, FindsAClockThatWasSetInATenthOfASecondAndKnowsItAgain) {
  for (const double by : {-0.3, 0.5, -40.0, 40.0, -4000.0, 4000.0}) {
    const auto seen = watch({.ahead_s = [by](double t) { return t < 4.0 ? 3.0 : 3.0 + by; }});
    EXPECT_EQ(seen.times_set, 1) << by;
    EXPECT_GE(seen.set_at, 4.0) << by;  // two seconds and more after the start: known well by then
    EXPECT_LE(seen.set_at, 4.1) << by;
    EXPECT_NEAR(seen.last_error, 0.0, 0.003) << by;
  }
}

TEST(WatchedClock, IsNotFooledByABurstOfLateSamplesOrABusyMachine) {
  // Half a second's samples all arrive at its end, each less late than the one before.
  const auto burst = watch({.late_s = [](double t) { return t < 4.0 || t > 4.5 ? 0.0 : 4.5 - t; }});
  EXPECT_EQ(burst.times_set, 0);
  EXPECT_NEAR(burst.last_error, 0.0, 0.003);
  // One that falls behind and recovers.
  const auto busy =
      watch({.late_s = [](double t) { return t < 4.0 || t > 5.0 ? 0.0 : 1.5 * std::min(t - 4.0, 5.0 - t); }});
  EXPECT_EQ(busy.times_set, 0);
  // One that was busy while the clock was learned.
  const auto quicker = watch({.late_s = [](double t) { return t < 4.0 ? 0.1 : 0.0; }});
  EXPECT_EQ(quicker.times_set, 0);
  EXPECT_NEAR(quicker.last_error, 0.0, 0.003);
}

}  // namespace
}  // namespace palpate::server::graphics
