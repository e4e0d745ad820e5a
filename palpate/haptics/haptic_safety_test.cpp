// Each way in which a hand could be hurt, and what the loop does about it. A watchdog acts within 5 ms,
// forces are gone within 20 ms, and on the way down as everywhere the device's slew limit holds.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "palpate/haptics/haptic_bench_test.h"

namespace palpate::haptics {
namespace {

constexpr double kPush = 1.3;  // N, just below what motors can hold for ever

struct PushedHand : HapticBench {
  PushedHand() : HapticBench(without_ramp()) {
    message.continuous = {0.0, kPush, 0.0};
    live(20);
    EXPECT_NEAR(felt(), kPush, 1e-9);
    EXPECT_EQ(loop.state(), ForceState::running);
    arm.steepest = 0.0;
  }
  double felt() const { return HapticBench::felt().norm(); }
};

struct Fall {
  int first_less = -1, gone = -1;  // ms after the fault began
};

// Ticks until a while after; `spoiled` is the tick with the fault in it.
template <typename Spoiled>
Fall watch(PushedHand& hand, Spoiled spoiled) {
  Fall fall;
  const double before = hand.arm.force.norm();
  for (int ms = 1; ms <= 60; ++ms) {
    spoiled();
    const double now = hand.arm.force.norm();
    if (fall.first_less < 0 && now < before - 1e-9) fall.first_less = ms;
    if (fall.gone < 0 && now == 0.0) fall.gone = ms;
    if (fall.gone >= 0) {
      EXPECT_EQ(now, 0.0) << ms;
    }
  }
  EXPECT_TRUE(hand.arm.finite);
  EXPECT_LE(hand.arm.steepest, 3.0 + 1e-9);
  return fall;
}

TEST(HapticSafety, ASilentPhysicsLoopIsNoticedWithin5MsAndTheForceIsGoneWithin20Ms) {
  PushedHand hand;
  const Fall fall = watch(hand, [&] { hand.tick(); });
  EXPECT_GT(fall.first_less, 1);  // one late message is none
  EXPECT_LE(fall.first_less, 5);
  EXPECT_GT(fall.gone, 0);
  EXPECT_LE(fall.gone, 20);
  EXPECT_EQ(hand.loop.fault(), ForceFault::stale_input);
  EXPECT_EQ(hand.loop.state(), ForceState::degraded);
  hand.live(5);  // comes back by itself
  EXPECT_EQ(hand.loop.state(), ForceState::running);
  EXPECT_NEAR(hand.felt(), kPush, 1e-9);
}

TEST(HapticSafety, APushTenTimesBeyondThePeakIsGoneWithin20MsToo) {
  PushedHand hand;
  hand.message.continuous = {0.0, 90.0, 0.0};
  hand.live(6);
  EXPECT_GT(hand.arm.force.norm(), 8.0);
  hand.arm.steepest = 0.0;
  const Fall fall = watch(hand, [&] { hand.tick(); });
  EXPECT_LE(fall.first_less, 5 + 1);  // at the peak the fade shows a tick later
  EXPECT_GT(fall.gone, 0);
  EXPECT_LE(fall.gone, 20);
}

TEST(HapticSafety, AFrozenPhysicsLoopThatGoesOnTalkingIsTheSame) {
  PushedHand hand;
  const Fall fall = watch(hand, [&] {
    hand.input.write(hand.message);  // the same state again: its time stands still
    hand.tick();
  });
  EXPECT_LE(fall.first_less, 5);
  EXPECT_GT(fall.gone, 0);
  EXPECT_LE(fall.gone, 20);
  EXPECT_EQ(hand.loop.fault(), ForceFault::stale_input);
}

TEST(HapticSafety, AnArmWhoseStampsStandStillIsNoticedWithin5Ms) {
  PushedHand hand;
  hand.arm.frozen = true;
  const Fall fall = watch(hand, [&] { hand.live(); });
  EXPECT_LE(fall.first_less, 5);
  EXPECT_GT(fall.gone, 0);
  EXPECT_LE(fall.gone, 20);
  EXPECT_EQ(hand.loop.fault(), ForceFault::arm_silent);
  hand.arm.frozen = false;
  hand.live(5);
  EXPECT_EQ(hand.loop.state(), ForceState::running);
}

TEST(HapticSafety, AnArmWhoseStampsRunBackwardsIsSilent) {
  for (const auto back : {std::chrono::milliseconds(2), std::chrono::milliseconds(2000)}) {
    PushedHand hand;
    hand.arm.frozen = true;
    hand.arm.sample.stamp += -Duration(back);
    const Fall fall = watch(hand, [&] {
      hand.arm.sample.stamp += std::chrono::milliseconds(-1);
      hand.live();
    });
    EXPECT_LE(fall.first_less, 5);
    EXPECT_GT(fall.gone, 0);
    EXPECT_LE(fall.gone, 20);
    EXPECT_EQ(hand.loop.fault(), ForceFault::arm_silent);
  }
}

TEST(HapticSafety, ReadingsOfThePastBetweenTheNewOnesAreNoneToPushBy) {
  PushedHand hand;
  hand.arm.frozen = true;
  Instant<ArmClock> time = hand.arm.sample.stamp;
  bool old = false;
  const Fall fall = watch(hand, [&] {
    time += std::chrono::milliseconds(1);
    old = !old;
    hand.arm.sample.stamp = old ? time - std::chrono::seconds(2) : time;
    hand.live();
  });
  EXPECT_LE(fall.first_less, 6);
  EXPECT_GT(fall.gone, 0);
  EXPECT_LE(fall.gone, 20);
}

TEST(HapticSafety, AnArmWhoseClockBeganAnewComesBackWithTheRamp) {
  HapticBench hand(bench_settings());
  hand.message.continuous = {0.0, kPush, 0.0};
  hand.live(1500);
  EXPECT_NEAR(hand.felt().norm(), kPush, 1e-9);
  hand.arm.sample.stamp = {};  // it was plugged in again
  hand.live(40);
  EXPECT_EQ(hand.arm.force.norm(), 0.0);
  double most_rise = 0.0, before = 0.0;
  for (int ms = 0; ms < 1500; ++ms) {
    hand.live();
    most_rise = std::max(most_rise, hand.felt().norm() - before);
    before = hand.felt().norm();
  }
  EXPECT_NEAR(before, kPush, 1e-9);
  EXPECT_LT(most_rise, 0.05) << "N in a millisecond: the ramp takes a second";
  EXPECT_EQ(hand.loop.state(), ForceState::running);
}

// A device whose readings come in bursts tells of a few microseconds out of order, and of nothing wrong.
TEST(HapticSafety, AStampThatIsHardlyOlderIsNoFault) {
  PushedHand hand;
  for (int ms = 0; ms < 100; ++ms) {
    hand.arm.sample.stamp += std::chrono::microseconds(ms % 2 == 0 ? -1300 : 700);
    hand.live();
    EXPECT_NEAR(hand.felt(), kPush, 1e-9);
  }
}

TEST(HapticSafety, ADisconnectedArmStaysOffUntilItIsBackAndSomebodyRearms) {
  PushedHand hand;
  hand.arm.sample.connected = false;
  const Fall fall = watch(hand, [&] { hand.live(); });
  EXPECT_EQ(fall.first_less, 1);
  EXPECT_LE(fall.gone, 20);
  EXPECT_EQ(hand.loop.state(), ForceState::safe);
  EXPECT_EQ(hand.loop.fault(), ForceFault::arm_lost);
  EXPECT_FALSE(hand.loop.rearm()) << "still unplugged";
  hand.arm.sample.connected = true;
  hand.live(100);
  EXPECT_EQ(hand.arm.force.norm(), 0.0);
  EXPECT_TRUE(hand.loop.rearm());
  hand.live(5);
  EXPECT_NEAR(hand.felt(), kPush, 1e-9);
}

TEST(HapticSafety, APoseThatIsNoNumberFadesTheForceAndKeepsTheLastTip) {
  for (const double bad : {std::nan(""), std::numeric_limits<double>::infinity()})
    for (const bool gimbal : {false, true}) {
      PushedHand hand;
      const Vector3 tip = hand.loop.tip().X_world_tip.translation;
      (gimbal ? hand.arm.sample.gimbal[1] : hand.arm.sample.joints[1]) = bad;
      const Fall fall = watch(hand, [&] { hand.live(); });
      EXPECT_EQ(fall.first_less, 1);
      EXPECT_GT(fall.gone, 0);
      EXPECT_LE(fall.gone, 20);
      EXPECT_EQ(hand.loop.fault(), ForceFault::bad_reading);
      EXPECT_EQ(hand.loop.tip().X_world_tip.translation, tip);
      EXPECT_EQ(hand.loop.statistics().bad_samples, 60u);
    }
}

TEST(HapticSafety, AForceThatIsNoNumberFadesWhatIsHeld) {
  for (const double bad : {std::nan(""), std::numeric_limits<double>::infinity(), 1e300, 1000.0, -101.0}) {
    PushedHand hand;
    hand.message.continuous.x() = bad;
    const Fall fall = watch(hand, [&] { hand.live(); });
    EXPECT_EQ(fall.first_less, 1);
    EXPECT_LE(fall.gone, 20);
    EXPECT_EQ(hand.loop.fault(), ForceFault::bad_force);
  }
}

TEST(HapticSafety, AnArmThatRunsAwayStaysOffUntilRearmed) {
  PushedHand hand;
  double angle = 0.0;
  // 0.02 rad per tick at 0.3 m: 6 m/s.
  const Fall fall =
      watch(hand, [&] { hand.arm.sample.joints[0] = angle += angle < 0.5 ? 0.02 : 0.0, hand.live(); });
  EXPECT_GT(fall.gone, 0);
  EXPECT_EQ(hand.loop.fault(), ForceFault::overspeed);
  EXPECT_EQ(hand.loop.state(), ForceState::safe);
  hand.live(100);
  EXPECT_EQ(hand.arm.force.norm(), 0.0);
  EXPECT_TRUE(hand.loop.rearm());
  hand.live(5);
  EXPECT_GT(hand.felt(), 1.0);
}

TEST(HapticSafety, ASlowerArmsSpeedLimitIsItsOwn) {
  const auto state_at = [](const ForceLimits& limits, double rad_per_tick) {
    HapticSettings settings = bench_settings();
    settings.limits = limits;
    HapticBench bench(settings);
    for (int i = 0; i < 100; ++i) bench.arm.sample.joints[0] += rad_per_tick, bench.live();
    return bench.loop.state();
  };
  // 0.006 rad per tick at 0.3 m: about 1.8 m/s.
  EXPECT_EQ(state_at(force_limits_of("phantom-premium-1.5"), 0.006), ForceState::running);
  EXPECT_EQ(state_at(force_limits_of("touch"), 0.006), ForceState::safe);
}

TEST(HapticSafety, OutsideTheWorkspaceThereIsNoForce) {
  PushedHand hand;
  double& angle = hand.arm.sample.joints[1];  // up to where the arm is folded, at 1.7 m/s
  for (int i = 0; i < 300 && hand.loop.fault() == ForceFault::none; ++i) angle += 0.008, hand.live();
  ASSERT_EQ(hand.loop.fault(), ForceFault::outside_workspace);
  EXPECT_LT(angle, 1.9);
  const Fall fall = watch(hand, [&] { hand.live(); });
  EXPECT_EQ(fall.first_less, 1);
  EXPECT_GT(fall.gone, 0);
  EXPECT_LE(fall.gone, 20);
  EXPECT_EQ(hand.loop.state(), ForceState::degraded);
  for (int i = 0; i < 300; ++i) angle = std::max(0.5, angle - 0.008), hand.live();
  EXPECT_NEAR(hand.felt(), kPush, 1e-9);
}

TEST(HapticSafety, BeyondTheJointRangeThereIsNoForceEither) {
  PushedHand hand;
  double& angle = hand.arm.sample.joints[0];
  for (int i = 0; i < 400; ++i) angle += 0.004, hand.live();
  EXPECT_EQ(hand.loop.fault(), ForceFault::outside_workspace);
  EXPECT_EQ(hand.arm.force.norm(), 0.0);
}

TEST(HapticSafety, ALoopThatStoodStillStartsAgainWithoutAPull) {
  PushedHand hand;
  hand.message.continuous.setZero();
  hand.live(20);
  hand.message.impact = bench_impact(1, 3.0, hand.now);
  hand.live(2);
  EXPECT_GT(hand.arm.force.norm(), 1.0);
  const Vector3 along = hand.message.impact.direction;
  hand.now += seconds(0.3);  // the machine stood still, the device held the force
  for (int i = 0; i < 200; ++i) {
    hand.live();
    if (i == 0) {
      EXPECT_EQ(hand.loop.fault(), ForceFault::late_tick);
    }
    EXPECT_GT(hand.arm.felt(bench_calibration()).dot(along), -1e-9) << i;
  }
  EXPECT_EQ(hand.arm.force.norm(), 0.0);
}

TEST(HapticSafety, AReadingThatLeapsCannotMakeTheCommandLeap) {
  PushedHand hand;
  hand.message.continuous = {0.0, 8.0, 0.0};
  hand.live(6);
  hand.arm.steepest = 0.0;
  // Another pose from one tick to the next: the way from force to device leaps, the command must not.
  for (int i = 0; i < 40; ++i) {
    hand.arm.sample.joints = i % 2 == 0 ? Vector3(0.7, 1.3, -0.1) : Vector3(-0.6, 0.0, 1.0);
    hand.live();
  }
  EXPECT_LE(hand.arm.steepest, 3.0 + 1e-9);
  EXPECT_EQ(hand.loop.state(), ForceState::safe);
  EXPECT_EQ(hand.arm.force.norm(), 0.0);
}

TEST(HapticSafety, TheLastClampActsAndTripsOnWhateverComes) {
  LastClamp clamp(ForceLimits{}, 0.001);
  EXPECT_EQ(clamp.pass({1.0, 2.0, -1.0}), Vector3(1.0, 2.0, -1.0));
  EXPECT_FALSE(clamp.tripped());
  EXPECT_NEAR((clamp.pass({1.0, 6.0, -1.0}) - Vector3(1.0, 5.0, -1.0)).norm(), 0.0, 1e-12);
  EXPECT_TRUE(clamp.tripped());
  for (int i = 0; i < 10; ++i) clamp.pass({0.0, 1e9, 0.0});
  EXPECT_NEAR(clamp.last().y(), 8.5, 1e-9);
  EXPECT_TRUE(clamp.tripped());
  clamp.pass({std::nan(""), 0.0, 0.0});
  EXPECT_TRUE(clamp.tripped());
  EXPECT_NEAR(clamp.last().y(), 5.5, 1e-9);  // down at the slew limit, not at once
}

TEST(HapticSafety, ATripIsToldOnceWithItsTick) {
  PushedHand hand;
  EXPECT_EQ(hand.loop.condition().trips, 0u);
  for (int i = 0; i < 30; ++i) hand.tick();
  auto condition = hand.loop.condition();
  EXPECT_EQ(condition.trips, 1u);
  EXPECT_EQ(condition.trip_fault, ForceFault::stale_input);
  EXPECT_EQ(condition.trip_tick, 25u);  // 20 good ones and 5 without input
  hand.live(10);
  hand.arm.sample.connected = false;
  hand.live(10);
  condition = hand.loop.condition();
  EXPECT_EQ(condition.trips, 2u);
  EXPECT_EQ(condition.trip_fault, ForceFault::arm_lost);
  EXPECT_EQ(condition.state, ForceState::safe);
}

}  // namespace
}  // namespace palpate::haptics
