#include "palpate/time/clock.h"

#include <gtest/gtest.h>

#include <concepts>

namespace palpate::inline time {
namespace {

// Instants of two clocks neither subtract nor compare.
template <typename A, typename B>
concept Subtractable = requires(Instant<A> a, Instant<B> b) {
  a - b;
};
static_assert(Subtractable<ArmClock, ArmClock>);
static_assert(!Subtractable<ArmClock, TrackerClock>);
static_assert(!std::convertible_to<Instant<ArmClock>, Instant<PhysicsClock>>);

TEST(VirtualClock, MovesOnlyForward) {
  VirtualClock<PhysicsClock> clock;
  clock.sleep_until(Instant<PhysicsClock>::from_seconds(1.0));
  clock.sleep_until(Instant<PhysicsClock>::from_seconds(0.5));
  EXPECT_EQ(clock.now().seconds(), 1.0);
}

TEST(MonotonicClock, ADisguisedClockShowsItsOffsetAndDrift) {
  const MonotonicClock<GraphicsClock> clock(1.25, 80.0, 0);
  EXPECT_EQ(clock.from_monotonic(10'000'000'000).ns(), 11'250'000'000 + 800'000);
  for (std::int64_t t : {0ll, 123'456'789ll, 86'400'000'000'000ll})
    EXPECT_NEAR(static_cast<double>(clock.to_monotonic(clock.from_monotonic(t)) - t), 0.0, 1.0);
}

// An old state of another host's clock may lie before this machine's start.
TEST(MonotonicClock, ATimeBeforeTheMachineBeganIsOver) {
  MonotonicClock<PhysicsClock> clock;
  clock.sleep_until(Instant<PhysicsClock>{Duration(-1)});
  clock.sleep_until(Instant<PhysicsClock>{Duration(-3'000'000'000)});
  MonotonicClock<PhysicsClock> ahead(1e6, 0.0);
  ahead.sleep_until(Instant<PhysicsClock>::from_seconds(1.0));
  EXPECT_GT(clock.now().ns(), 0);
}

TEST(Instant, SecondsRoundToTheNearestNanosecond) {
  EXPECT_EQ(Instant<TrueTime>::from_seconds(0.1 + 0.2).ns(), 300'000'000);
}

}  // namespace
}  // namespace palpate::inline time
