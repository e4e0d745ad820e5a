#include "palpate/time/periodic_loop.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "palpate/core/random.h"

namespace palpate::inline time {
namespace {

using namespace std::chrono_literals;

TEST(JitterHistogram, ItsQuantilesAreThoseOfTheSortedListToASixteenth) {
  Random random(1, "histogram");
  JitterHistogram histogram;
  std::vector<double> all;
  for (int i = 0; i < 20'000; ++i) {
    all.push_back(std::floor(std::exp(18.0 * random.uniform())));  // 1 ns ... 66 ms
    histogram.add(Duration(static_cast<std::int64_t>(all.back())));
  }
  std::sort(all.begin(), all.end());
  for (double q : {0.0, 0.01, 0.5, 0.9, 0.99, 0.999, 1.0}) {
    const double exact = all[std::min(all.size() - 1, static_cast<std::size_t>(q * 20'000))];
    const double found = static_cast<double>(histogram.quantile(q).count());
    EXPECT_GE(found, exact) << q;
    EXPECT_LE(found, exact * (1.0 + 1.0 / 16.0)) << q;
  }
  EXPECT_EQ(static_cast<double>(histogram.max().count()), all.back());
  EXPECT_EQ(histogram.count(), 20'000u);
}

TEST(JitterHistogram, ItsHalfOctavesHoldWhatLiesBetweenTheirEdges) {
  JitterHistogram histogram;
  constexpr std::size_t kLast = JitterHistogram::kHalfOctaves;
  for (std::size_t i = 0; i < kLast; ++i) {
    histogram.add(Duration(static_cast<std::int64_t>(JitterHistogram::half_octave_ns(i))));
    histogram.add(Duration(static_cast<std::int64_t>(JitterHistogram::half_octave_ns(i + 1)) - 1));
  }
  for (const auto count : histogram.half_octaves()) EXPECT_EQ(count, 2u);
}

TEST(JitterHistogram, TakesEveryDuration) {
  JitterHistogram histogram;
  EXPECT_EQ(histogram.quantile(0.5), Duration(0));
  histogram.add(Duration(-5));
  EXPECT_EQ(histogram.quantile(1.0), Duration(0));
  histogram.add(Duration(std::numeric_limits<std::int64_t>::max()));
  EXPECT_EQ(histogram.max(), Duration(std::numeric_limits<std::int64_t>::max()));
  EXPECT_EQ(histogram.count(), 2u);
}

// Wakes exactly when asked; time passes only while the loop sleeps and where
// the callable says so.
const PeriodicLoopSettings kVirtual{.rate_hz = 1000.0, .real_time = false};

TEST(PeriodicLoop, CountsWhatTheCallableOverran) {
  VirtualClock<PhysicsClock> clock;
  std::vector<std::int64_t> deadlines;
  std::atomic<bool> enough{false};
  PeriodicLoop<PhysicsClock> loop(clock, kVirtual, [&](Instant<PhysicsClock> due) {
    if (deadlines.size() < 12) deadlines.push_back(due.ns());
    clock.advance(100us);
    if (due.ns() == 3'000'000) clock.advance(3150us);  // to 6.25 ms: 4, 5 and 6 are gone
    if (due.ns() == 9'000'000) clock.advance(900us);   // to 10 ms sharp: 10 is gone
    if (deadlines.size() == 12) {
      enough.store(true);
      enough.notify_all();
      std::this_thread::yield();
    }
  });
  enough.wait(false);
  loop.stop();
  const std::vector<std::int64_t> expected{1, 2, 3, 7, 8, 9, 11, 12, 13, 14, 15, 16};
  for (std::size_t i = 0; i < expected.size(); ++i) EXPECT_EQ(deadlines[i], expected[i] * 1'000'000);
  const LoopStatistics statistics = loop.statistics();
  EXPECT_EQ(statistics.overruns, 2u);
  EXPECT_EQ(statistics.missed, 4u);
  EXPECT_EQ(statistics.missed_in_a_row, 3u);
  EXPECT_GE(statistics.ticks, 12u);
  EXPECT_EQ(statistics.late_max, Duration(0));
  EXPECT_EQ(statistics.busy_max, 3250us);
}

TEST(PeriodicLoop, ItsRateIsOfTheTimeInWhichItRan) {
  VirtualClock<PhysicsClock> clock;
  clock.advance(5s);
  std::atomic<int> ticks{0};
  PeriodicLoop<PhysicsClock> loop(clock, kVirtual, [&](Instant<PhysicsClock>) {
    if (++ticks == 1000) ticks.notify_all();
  });
  for (int seen = ticks; seen < 1000; seen = ticks) ticks.wait(seen);
  loop.stop();
  clock.advance(7s);
  EXPECT_NEAR(loop.statistics().rate_hz, 1000.0, 2.0);  // the last period was not waited for to its end
}

TEST(PeriodicLoop, ItsDeadlinesDoNotWanderFromTheGrid) {
  VirtualClock<PhysicsClock> clock;
  std::atomic<std::int64_t> at_3000{0};
  int tick = 0;
  PeriodicLoopSettings settings = kVirtual;
  settings.rate_hz = 30.0;  // no whole number of nanoseconds
  PeriodicLoop<PhysicsClock> loop(clock, settings, [&](Instant<PhysicsClock> due) {
    if (++tick != 3000) return;
    at_3000.store(due.ns());
    at_3000.notify_all();
  });
  at_3000.wait(0);
  EXPECT_EQ(at_3000.load(), 100'000'000'000);
}

TEST(PeriodicLoop, RunsOnTheMachinesClockWithWhateverRightsItGets) {
  MonotonicClock<PhysicsClock> clock;
  for (bool real_time : {false, true}) {
    std::atomic<int> ticks{0};
    std::int64_t early = 0, before = 0, unordered = 0;
    PeriodicLoop<PhysicsClock> loop(clock, {.real_time = real_time}, [&](Instant<PhysicsClock> due) {
      early += clock.now() < due;
      unordered += due.ns() <= before;
      before = due.ns();
      if (++ticks == 50) ticks.notify_all();
    });
    LoopStatistics meanwhile;
    for (int seen = ticks; seen < 50; seen = ticks) meanwhile = loop.statistics();
    loop.stop();
    const LoopStatistics statistics = loop.statistics();
    EXPECT_EQ(early, 0);
    EXPECT_EQ(unordered, 0);
    EXPECT_EQ(statistics.ticks, static_cast<std::uint64_t>(ticks.load()));
    EXPECT_LE(meanwhile.ticks, statistics.ticks);
    EXPECT_LE(statistics.late_p50, statistics.late_p99);
    EXPECT_LE(statistics.late_p99, statistics.late_p999);
    EXPECT_LE(statistics.late_p999, statistics.late_max);
    EXPECT_FALSE(!real_time && loop.grant().fifo());
    EXPECT_EQ(loop.grant().describe().find('\n'), std::string::npos);
  }
}

TEST(PeriodicLoop, StopsTwiceAndAtOnce) {
  MonotonicClock<PhysicsClock> clock;
  PeriodicLoop<PhysicsClock> loop(clock, {.real_time = false}, [](Instant<PhysicsClock>) {});
  loop.stop();
  const std::uint64_t ticks = loop.statistics().ticks;
  loop.stop();
  EXPECT_EQ(loop.statistics().ticks, ticks);
}

TEST(PeriodicLoop, ARateThatMakesNoSenseThrows) {
  MonotonicClock<PhysicsClock> clock;
  for (double rate : {0.0, -1.0, 1e9, std::nan("")})
    EXPECT_THROW(PeriodicLoop<PhysicsClock>(clock, {.rate_hz = rate}, [](Instant<PhysicsClock>) {}),
                 std::invalid_argument);
}

}  // namespace
}  // namespace palpate::inline time
