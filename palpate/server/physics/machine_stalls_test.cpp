#include "palpate/server/physics/machine_stalls.h"

#include <gtest/gtest.h>
#include <sched.h>

#include <algorithm>
#include <atomic>
#include <thread>

namespace palpate::server::physics {
namespace {

using std::chrono::milliseconds;

// Its waits end late now and then, as on a machine that does other things.
class UnreliableClock : public Clock<PhysicsClock> {
 public:
  Instant<PhysicsClock> now() const override { return {Duration(ns_.load())}; }
  void sleep_until(Instant<PhysicsClock> t) override {
    const int sleep = ++sleeps_;
    const Duration late = sleep % 10 == 0   ? milliseconds(20)
                          : sleep % 10 == 5 ? milliseconds(4)
                                            : Duration(0);
    std::this_thread::sleep_for(std::chrono::microseconds(100));
    ns_ = std::max(ns_.load(), (t + late).ns());
    if (late >= MachineStalls::kStall) ++stalled_;
  }
  int stalled() const { return stalled_; }

 private:
  std::atomic<std::int64_t> ns_{1'000'000'000};
  std::atomic<int> sleeps_{0}, stalled_{0};
};

TEST(MachineStalls, AreWaitsThatEndedFiveMillisecondsLate) {
  // One core, one watch: this thread's affinity is what the watches are made for.
  cpu_set_t before, one;
  ASSERT_EQ(sched_getaffinity(0, sizeof before, &before), 0);
  CPU_ZERO(&one);
  for (int core = 0; core < CPU_SETSIZE; ++core)
    if (CPU_ISSET(core, &before)) {
      CPU_SET(core, &one);
      break;
    }
  ASSERT_EQ(sched_setaffinity(0, sizeof one, &one), 0);
  UnreliableClock clock;
  MachineStalls stalls(clock, false);
  while (clock.stalled() < 5) std::this_thread::sleep_for(milliseconds(1));
  stalls.stop();
  ASSERT_EQ(sched_setaffinity(0, sizeof before, &before), 0);
  EXPECT_EQ(stalls.count(), static_cast<std::uint64_t>(clock.stalled()));
  ASSERT_EQ(stalls.stalls().size(), stalls.count());
  for (const MachineStall& stall : stalls.stalls()) EXPECT_EQ(stall.to - stall.from, milliseconds(20));
  EXPECT_EQ(stalls.longest(), milliseconds(20));
}

TEST(MachineStalls, ATripIsWithinOneWhereTheyOverlap) {
  const auto at = [](int ms) { return Instant<PhysicsClock>{milliseconds(ms)}; };
  haptics::LoggedTrip late_tick{
      .trip = {.tick = 1, .time = at(1000)}, .away_s = 0.001, .outage_s = 0.120, .file = {}};
  EXPECT_TRUE(within_stall(late_tick, {{at(890), at(999), 0}}));
  EXPECT_TRUE(within_stall(late_tick, {{at(0), at(10), 1}, {at(990), at(1010), 0}}));
  EXPECT_FALSE(within_stall(late_tick, {{at(800), at(870), 0}, {at(1010), at(1020), 0}}));
  EXPECT_FALSE(within_stall(late_tick, {}));
  haptics::LoggedTrip silent{
      .trip = {.tick = 1, .time = at(1000)}, .away_s = 0.030, .outage_s = 0.030, .file = {}};
  EXPECT_TRUE(within_stall(silent, {{at(980), at(996), 0}}));
  EXPECT_FALSE(within_stall(silent, {{at(960), at(990), 0}}));
}

}  // namespace
}  // namespace palpate::server::physics
