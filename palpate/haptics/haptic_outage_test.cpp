// A force that comes back after an outage: what the hand gets for each stall of the loop, of physics and of
// the arm, from 5 ms to 2 s, and that no stall reads as overspeed. The hand sinks into a wall meanwhile, so
// that what the present depth asks for is far more than what was held.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "palpate/haptics/haptic_bench_test.h"

namespace palpate::haptics {
namespace {

constexpr double kStiffness = 800.0;  // N/m
constexpr double kDepth = 0.001;      // m, before the stall
enum class Stall { loop, physics, arm, everything };

// A hand in a wall of one axis: the encoders turn, the wall answers to where the tip is.
struct HandInAWall : HapticBench {
  explicit HandInAWall(double sink_m_s) : sink(sink_m_s) {
    arm.lets_go = true;
    live_ticks(1300);
    held = HapticBench::felt().norm();
    EXPECT_NEAR(held, kStiffness * kDepth, 1e-2 * kStiffness * kDepth);
    arm.steepest = 0.0;
  }
  void live_ticks(int ticks) {
    for (int i = 0; i < ticks; ++i) millisecond(true, true, true);
  }
  // A millisecond in which loop, physics and arm run, or do not.
  void millisecond(bool loop_runs, bool physics_runs, bool arm_runs) {
    now += period;
    if (stalled) depth += sink * 1e-3;
    if (arm_runs) {
      arm.sample.joints[0] = 0.1 - depth / kLever;
      arm.sample.stamp += period;
      arm.sample.waited = Duration(0);
      seen = depth;
    } else {
      arm.sample.waited += period;
    }
    if (physics_runs) {
      message.time = now;
      message.continuous = {std::max(0.0, kStiffness * seen), 0.0, 0.0};
      input.write(message);
    }
    arm.frozen = true;  // its stamps are those above
    if (loop_runs) {
      loop.tick(now);
      since_command = 0;
    } else if (++since_command > 20) {
      arm.let_go();
    }
  }
  static constexpr double kLever = 0.3;  // m, about
  double sink, depth = kDepth, seen = kDepth, held = 0.0;
  bool stalled = false;
  int since_command = 0;
};

void stall(HandInAWall& hand, Stall which, int ms) {
  hand.stalled = true;
  for (int i = 1; i < ms; ++i)
    hand.millisecond(which != Stall::loop && which != Stall::everything,
                     which != Stall::physics && which != Stall::everything,
                     which != Stall::arm && which != Stall::everything);
}

TEST(HapticOutage, TheForceComesBackByTheRule) {
  for (const Stall which : {Stall::loop, Stall::physics, Stall::arm, Stall::everything})
    for (const int ms : {5, 6, 8, 12, 18, 25, 35, 49, 70, 120, 500, 1500, 2000})
      for (const double sink : {0.0, 0.01, 0.1}) {
        SCOPED_TRACE(testing::Message() << "stall " << static_cast<int>(which) << " of " << ms
                                        << " ms, sinking " << sink << " m/s");
        HandInAWall hand(sink);
        stall(hand, which, ms);
        const double still_held = hand.arm.force.norm();
        const bool brief = ms <= 50, stood_still = which == Stall::loop || which == Stall::everything;
        if (ms == 5 && !stood_still) continue;  // the next reading or input comes just in time: no outage
        double most_early = 0.0, at_50 = 0.0;
        for (int after = 0; after < 1200; ++after) {
          hand.millisecond(true, true, true);
          const double force = hand.arm.force.norm();
          if (after == 0 && !brief) {
            ASSERT_EQ(force, 0.0);
          }
          if (after == 0 && brief && stood_still) {
            ASSERT_LE(force, still_held + 1e-3);
          }
          if (after < 50) most_early = std::max(most_early, hand.felt().norm());
          if (after == 49) at_50 = hand.felt().norm();
          // The ramp of 1 s, of what the depth asks for.
          if (!brief) {
            ASSERT_LE(hand.felt().norm(), kStiffness * hand.depth * (1e-3 * after + 1e-9)) << after;
          }
        }
        if (brief) {
          EXPECT_LE(most_early, hand.held * 1.02);
          const double requested = kStiffness * hand.depth;
          EXPECT_GE(at_50, 0.98 * std::min(hand.held, requested));
        }
        EXPECT_EQ(hand.loop.state() == ForceState::safe, false) << "told " << name_of(hand.loop.fault());
        EXPECT_LE(hand.arm.steepest, 3.0 + 1e-9);
      }
}

TEST(HapticOutage, AfterIt1sLaterTheWholeForceOfTheDepthIsThere) {
  for (const int ms : {8, 30, 300}) {
    HandInAWall hand(ms > 100 ? 0.001 : 0.005);
    stall(hand, Stall::everything, ms);
    hand.stalled = false;
    hand.live_ticks(1300);
    EXPECT_NEAR(hand.arm.force.norm(), kStiffness * hand.depth, 0.05 * kStiffness * hand.depth) << ms;
  }
}

TEST(HapticOutage, NoStallReadsAsOverspeedBelowIt) {
  for (const double speed : {0.5, 1.5, 2.5})
    for (const int ms : {2, 4, 8, 16, 28, 60, 200}) {
      HapticBench bench(without_ramp());
      bench.arm.frozen = true;
      double angle = -0.6;
      const auto millisecond = [&](bool arm_runs, bool loop_runs) {
        bench.now += bench.period;
        angle += speed / 0.244 * 1e-3;
        if (arm_runs) {
          bench.arm.sample.joints[0] = angle;
          bench.arm.sample.stamp += bench.period;
        }
        bench.message.time = bench.now;
        bench.input.write(bench.message);
        if (loop_runs) bench.loop.tick(bench.now);
      };
      for (int i = 0; i < 20; ++i) millisecond(true, true);
      for (int i = 1; i < ms; ++i) millisecond(ms % 8 == 0, ms % 8 != 0);
      for (int i = 0; i < 20; ++i) millisecond(true, true);
      EXPECT_NE(bench.loop.state(), ForceState::safe) << speed << " m/s, " << ms << " ms";
      EXPECT_NEAR(bench.loop.tip().velocity.norm(), speed, 0.25 * speed);
    }
}

TEST(HapticOutage, RealOverspeedIsStillToldWithinMilliseconds) {
  HapticBench bench(without_ramp());
  bench.live(20);
  int told = -1;
  for (int i = 0; i < 20 && told < 0; ++i) {
    bench.arm.sample.joints[0] += 0.02;  // some 6 m/s
    bench.live();
    if (bench.loop.state() == ForceState::safe) told = i;
  }
  EXPECT_GE(told, 0);
  EXPECT_LE(told, 5);
}

TEST(HapticOutage, ImpactsOwedFromBeforeAnOutageAreDroppedAndCounted) {
  for (const int ms : {8, 30, 300}) {
    HapticBench bench(without_ramp());
    bench.live(20);
    bench.message.impact = bench_impact(1, 6.0, bench.now + bench.period);
    bench.live(2);
    EXPECT_GT(bench.arm.force.norm(), 1.0);
    bench.message.impact =
        bench_impact(2, 6.0, bench.now + seconds(0.002));  // felt during the stall, or never
    bench.message.earlier[0] = bench_impact(1, 6.0, bench.now);
    bench.now += seconds(1e-3 * ms);
    bench.live();
    const double after = bench.arm.force.norm();
    double most = 0.0;
    for (int i = 0; i < 100; ++i) {
      bench.live();
      most = std::max(most, bench.arm.force.norm());
    }
    EXPECT_LE(most, after) << ms;
    const HapticStatistics& s = bench.loop.statistics();
    EXPECT_EQ(s.dropped_impacts, 2u) << ms;
    EXPECT_EQ(s.impacts, 1u);
    EXPECT_GT(s.impulse_lost, 0.0);
    EXPECT_EQ(s.outages, ms <= 55 ? 1u : 0u);
  }
}

TEST(HapticOutage, AnImpactAfterTheOutageIsFelt) {
  HapticBench bench(without_ramp());
  bench.live(20);
  bench.now += seconds(0.030);
  bench.live(60);
  bench.message.impact = bench_impact(1, 2.0, bench.now + bench.period);
  bench.live(60);
  EXPECT_EQ(bench.loop.statistics().impacts, 1u);
  EXPECT_LT(bench.loop.statistics().lost_impulse_rel(), 1e-9);
}

}  // namespace
}  // namespace palpate::haptics
