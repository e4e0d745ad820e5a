// What arrives at the hand of an impact, through the whole chain: its course below the limits, its impulse
// beyond them, and the account of what did not arrive.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "palpate/core/random.h"
#include "palpate/haptics/haptic_bench_test.h"
#include "palpate/math/random_vector.h"

namespace palpate::haptics {
namespace {

constexpr scene::ContactModel kContacts[] = {scene::ContactModel::non_sticky, scene::ContactModel::paper,
                                             scene::ContactModel::hunt_crossley};

HapticSettings at_rate(double hz) {
  HapticSettings settings = without_ramp();
  settings.period = seconds(1.0 / hz);
  return settings;
}

Vector3 asked_of_hand(const scene::ImpactEvent& event) {
  return event.mass * (1.0 + event.restitution) * event.approach_speed * event.direction;
}

TEST(HapticImpact, BelowTheLimitsTheHandFeelsTheCourseOfTheModelTickByTick) {
  Random random(1, "haptic_blow/course");
  for (const auto model : kContacts)
    for (const double hz : {1000.0, 4000.0})
      for (int run = 0; run < 20; ++run) {
        HapticBench bench(at_rate(hz));
        bench.live(5);
        auto event =
            bench_impact(1, random.uniform(0.1, 0.8), bench.now + seconds(random.uniform(0.0, 2e-3)));
        event.model = model;
        bench.message.impact = event;
        ImpactRenderer course;  // itself tested against the equations of motion
        ASSERT_TRUE(course.start(event, bench.now + bench.period));
        Vector3 impulse = Vector3::Zero();
        for (double t = 0.0; t < 0.02; t += 1.0 / hz) {
          const Vector3 expected = course.tick(bench.now + bench.period, bench.period);
          bench.live();
          ASSERT_NEAR((bench.felt() - expected).norm(), 0.0, 1e-9) << static_cast<int>(model) << " at " << t;
          impulse += bench.felt() / hz;
        }
        const Vector3 requested = asked_of_hand(event);
        EXPECT_NEAR((impulse - requested).norm(), 0.0, 1e-9 * requested.norm());
        EXPECT_EQ(bench.loop.statistics().limited_ticks, 0u);
      }
}

// 4 m/s rise by more than 3 N in a millisecond and stay below 8.5 N; 12 m/s would go to 22 N.
TEST(HapticImpact, WhatTheSlewLimitShapesIsToldApartFromWhatThePeakCuts) {
  const auto after = [](double speed) {
    HapticBench bench(at_rate(1000.0));
    bench.live(5);
    bench.message.impact = bench_impact(1, speed, bench.now + bench.period);
    bench.live(60);
    return bench.loop.statistics();
  };
  const HapticStatistics gentle = after(0.5), steep = after(4.0), hard = after(12.0);
  EXPECT_EQ(gentle.limited_ticks, 0u);
  EXPECT_EQ(gentle.peak_limited_ticks, 0u);
  EXPECT_GT(steep.limited_ticks, 0u);
  EXPECT_EQ(steep.peak_limited_ticks, 0u);
  EXPECT_LT(steep.peak_n, 8.0);
  EXPECT_GT(hard.peak_limited_ticks, 0u);
  EXPECT_LT(hard.peak_limited_ticks, hard.limited_ticks);
  EXPECT_NEAR(hard.peak_n, 8.5, 0.5);  // the device's own axes stretch a force by a few percent
}

TEST(HapticImpact, ASecondImpactDuringTheFirstArrivesWholeWithIt) {
  Random random(2, "haptic_blow/second");
  for (const auto model : kContacts)
    for (const double hz : {1000.0, 4000.0})
      for (int run = 0; run < 20; ++run) {
        HapticBench bench(at_rate(hz));
        bench.live(5);
        auto first = bench_impact(1, 0.5, bench.now + seconds(random.uniform(0.0, 1e-3)));
        auto second = bench_impact(2, 0.4, first.start + seconds(random.uniform(1e-3, 3.5e-3)));
        first.model = second.model = model;
        second.direction = (first.direction + normal3(random, 0.5)).normalized();
        bench.message.impact = first;
        Vector3 impulse = Vector3::Zero();
        for (double t = 0.0; t < 0.04; t += 1.0 / hz) {
          if (second.start <= bench.now) bench.message.impact = second;
          bench.live();
          impulse += bench.felt() / hz;
        }
        const Vector3 requested = asked_of_hand(first) + asked_of_hand(second);
        EXPECT_NEAR((impulse - requested).norm(), 0.0, 1e-9 * requested.norm());
        EXPECT_EQ(bench.loop.statistics().impacts, 2u);
        EXPECT_LT(bench.loop.statistics().impulse_error_rel_max, 1e-9);
      }
}

TEST(HapticImpact, BeyondTheLimitsEveryModelsImpulseArrives) {
  for (const auto model : kContacts)
    for (const double hz : {1000.0, 4000.0})
      for (const double speed : {3.0, 12.0}) {
        HapticBench bench(at_rate(hz));
        bench.live(5);
        bench.message.impact = bench_impact(1, speed, bench.now + seconds(0.0003));
        bench.message.impact.model = model;
        Vector3 impulse = Vector3::Zero();
        for (double t = 0.0; t < 0.1; t += 1.0 / hz) {
          bench.live();
          impulse += bench.felt() / hz;
        }
        const Vector3 requested = asked_of_hand(bench.message.impact);
        EXPECT_NEAR((impulse - requested).norm(), 0.0, 1e-6 * requested.norm()) << speed;
        EXPECT_LT(bench.loop.statistics().lost_impulse_rel(), 1e-6);
        EXPECT_LE(bench.arm.largest, 8.5 * (1.0 + 1e-9));
        EXPECT_LE(bench.arm.steepest, 3000.0 / hz * (1.0 + 1e-9));
      }
}

// The way from force to device turns with the pose, and by far where encoders are off by 15 degrees; the
// motors grow warm and lower the peak. All of that while there is a backlog.
TEST(HapticImpact, WhileTheArmSwingsAndItsMotorsWarmWhatIsMissingIsReported) {
  Random random(3, "haptic_blow/room");
  rig::ArmCalibration far = bench_calibration();
  far.correction.offset = {0.0, 0.25, -0.2};
  for (const double pause : {0.4, 0.05, 0.03}) {  // s between impacts: motors stay cool, grow warm, hot
    HapticBench bench(without_ramp(), far);
    const auto joints_at = [](double t) {
      return Vector3(0.5 * std::sin(4.0 * t), 0.35 + 0.4 * std::sin(3.0 * t), 0.3 + 0.4 * std::cos(5.0 * t));
    };
    bench.arm.sample.joints = joints_at(0.0);
    bench.live(5);
    Vector3 felt = Vector3::Zero(), requested = Vector3::Zero();
    double next = 0.0;
    for (int i = 0; i < 8500; ++i) {
      const double t = 1e-3 * i;
      bench.arm.sample.joints = joints_at(t);
      if (t >= next && t < 8.0) {
        auto& event = bench.message.impact;
        event = bench_impact(event.number + 1, random.uniform(1.0, 8.0), bench.now);
        event.direction = normal3(random, 1.0).normalized();
        requested += asked_of_hand(event);
        next = t + pause;
      }
      bench.live();
      felt += 1e-3 * bench.felt();
    }
    const auto& s = bench.loop.statistics();
    EXPECT_LE(bench.arm.largest, 8.5 * (1.0 + 1e-9));
    EXPECT_LE(bench.arm.steepest, 3.0 * (1.0 + 1e-9));
    EXPECT_EQ(bench.loop.condition().trips, 0u);
    EXPECT_LE((requested - felt).norm(), s.impulse_lost + 1e-6 * s.impulse_requested) << pause;
    if (pause == 0.4) {
      EXPECT_EQ(s.warm_ticks, 0u);
      EXPECT_LT(s.lost_impulse_rel(), 1e-6);
    } else {
      EXPECT_GT(s.warm_ticks, 1000u);
    }
  }
}

// The turret's encoder counts a fifth too little, so the way from force to device is a turn that goes on with
// the arm: what it adds to each step has to be left free for it.
TEST(HapticImpact, WhileTheArmTurnsTheSlewLimitHoldsWithoutTheLastClamp) {
  rig::ArmCalibration calibration;
  calibration.correction.gain = {1.2, 1.0, 1.0};
  HapticBench bench(without_ramp(), calibration);
  bench.arm.sample.joints = {-0.8, 0.5, 0.3};
  bench.live(5);
  for (int i = 0; i < 300; ++i) {
    bench.arm.sample.joints[0] = -0.8 + 0.005 * i;
    if (i % 60 == 0)
      bench.message.impact = bench_impact(static_cast<std::uint64_t>(i / 60 + 1), 12.0, bench.now);
    bench.live();
  }
  EXPECT_EQ(bench.loop.condition().trips, 0u);
  EXPECT_GT(bench.arm.steepest, 2.9);
  EXPECT_LE(bench.arm.steepest, 3.0 * (1.0 + 1e-9));
  EXPECT_EQ(bench.loop.statistics().impacts, 5u);
  EXPECT_LT(bench.loop.statistics().lost_impulse_rel(), 1e-6);
}

TEST(HapticImpact, WhatTheDeviceItselfWithholdsCountsAsLost) {
  for (const double share : {0.0, 0.25, 1.0}) {
    HapticBench bench(without_ramp());
    bench.arm.withheld_share = share;
    bench.live(5);
    bench.message.impact = bench_impact(1, 2.0, bench.now);
    bench.live(60);
    EXPECT_NEAR(bench.loop.statistics().lost_impulse_rel(), share, 1e-9);
    EXPECT_NEAR(bench.loop.statistics().impulse_error_rel_max, share, 1e-9);
  }
}

TEST(HapticImpact, WhatTheDeviceWithholdsOfASustainedForceBetweenImpactsIsNoLossOfTheirs) {
  HapticBench bench(without_ramp());
  bench.message.impact = bench_impact(1, 2.0, bench.now);
  bench.live(60);
  bench.arm.withheld_share = 0.5;
  bench.message.continuous = {0.0, 1.0, 0.0};
  bench.live(100);
  bench.message.continuous.setZero();
  bench.live(10);
  bench.arm.withheld_share = 0.0;
  bench.message.impact = bench_impact(2, 2.0, bench.now);
  bench.live(60);
  EXPECT_EQ(bench.loop.statistics().impacts, 2u);
  EXPECT_LT(bench.loop.statistics().lost_impulse_rel(), 1e-9);
  EXPECT_NEAR(bench.loop.statistics().impulse_requested, 2.0 * 0.0027 * 1.8 * 2.0, 1e-12);
}

}  // namespace
}  // namespace palpate::haptics
