#include "palpate/haptics/haptic_loop.h"

#include <gtest/gtest.h>
#include <sys/resource.h>

#include <Eigen/LU>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <thread>

#include "palpate/core/random.h"
#include "palpate/haptics/haptic_bench_test.h"
#include "palpate/time/real_time.h"
#include "tests/allocation_count.h"
#include "tests/sanitized.h"

namespace palpate::haptics {
namespace {

TEST(HapticLoop, PublishesTheTipThroughTheCalibratedArm) {
  HapticBench bench;
  bench.live();
  scene::TipState tip;
  ASSERT_TRUE(bench.output.read(tip));
  const auto c = bench_calibration();
  const Vector3 theta(1.01 * 0.1, 0.99 * 0.5 + 0.02, 1.005 * 0.3 - 0.015);
  const auto expected = c.X_world_base * device::phantom_tip(theta, c.model.lengths);
  EXPECT_NEAR((tip.X_world_tip.translation - expected.m).norm(), 0.0, 1e-15);
  EXPECT_EQ(tip.time, bench.now);
  // A reading that is older says so, and the tip with it.
  bench.arm.sample.waited = std::chrono::microseconds(700);
  bench.tick();
  ASSERT_TRUE(bench.output.read(tip));
  EXPECT_EQ(tip.time, bench.now - bench.arm.sample.waited);
}

TEST(HapticLoop, VelocityFollowsTheArmThroughCoarseEncoders) {
  HapticBench bench;
  const auto c = bench_calibration();
  const auto theta_at = [](double t) {
    return Vector3(0.3 * std::sin(4 * t), 0.5 + 0.2 * std::sin(5 * t), 0.3);
  };
  double worst = 0.0;
  scene::TipState tip;
  for (int i = 0; i < 1000; ++i) {
    const double t = 1e-3 * (i + 1), quantum = 1.4e-4;
    const Vector3 psi = c.correction.undo(theta_at(t));
    bench.arm.sample.joints = quantum * (psi / quantum).array().round().matrix();
    bench.live();
    bench.output.read(tip);
    if (i < 50) continue;
    const auto place = [&](double s) {
      return (c.X_world_base * device::phantom_tip(theta_at(s), c.model.lengths)).m;
    };
    const Vector3 v = (place(t + 1e-5) - place(t - 1e-5)) / 2e-5;
    worst = std::max(worst, (tip.velocity - v).norm());
  }
  EXPECT_LT(worst, 0.025);  // lag 2 ms times up to 3 m/s^2, and encoder steps
}

template <typename Loop>
concept ShowsItsOwnViews = requires(Loop& loop) {
  loop.tip();
  loop.statistics();
  loop.state();
  loop.fault();
  loop.law_cost();
};
template <typename Loop>
concept CanBeLookedAt = requires(Loop& loop) {
  loop.condition();
  loop.records();
  loop.permit();
};
// Others have it as const.
static_assert(ShowsItsOwnViews<HapticLoop> && CanBeLookedAt<const HapticLoop>);
template <typename Loop>
concept ShowsTip = requires(Loop& loop) {
  loop.tip();
};
template <typename Loop>
concept ShowsStatistics = requires(Loop& loop) {
  loop.statistics();
};
static_assert(!ShowsTip<const HapticLoop> && !ShowsStatistics<const HapticLoop>);

TEST(HapticLoop, TheWholeImpulseArrivesInTheRightDirectionThroughTheDevicesOwnKinematics) {
  for (const double speed : {0.5, 2.3, 12.0}) {
    for (const double phase : {0.0, 0.0003, 0.00077}) {
      HapticBench bench(without_ramp());
      for (int i = 0; i < 5; ++i) bench.live();
      bench.message.impact = bench_impact(1, speed, bench.now + seconds(phase));
      const auto c = bench_calibration();
      Vector3 impulse = Vector3::Zero();
      for (int i = 0; i < 60; ++i) {
        bench.live();
        impulse += 1e-3 * bench.arm.felt(c);
        EXPECT_LE(bench.arm.force.norm(), 8.5);
      }
      const Vector3 requested = 0.0027 * 1.8 * speed * bench.message.impact.direction;
      EXPECT_NEAR((impulse - requested).norm() / requested.norm(), 0.0, 1e-9) << speed << " " << phase;
      const auto& s = bench.loop.statistics();
      EXPECT_EQ(s.impacts, 1u);
      EXPECT_LT(s.impulse_error_rel_max, 1e-9);
      EXPECT_NEAR(s.impulse_requested, requested.norm(), 1e-15);
      EXPECT_LT(s.lost_impulse_rel(), 1e-9);
    }
  }
}

TEST(HapticLoop, ARepeatedMessageIsOneImpact) {
  HapticBench bench(without_ramp());
  bench.message.impact = bench_impact(7, 1.0, bench.now);
  for (int i = 0; i < 40; ++i) bench.live();
  EXPECT_EQ(bench.loop.statistics().impacts, 1u);
  bench.message.impact = bench_impact(8, 1.0, bench.now);
  for (int i = 0; i < 40; ++i) bench.live();
  EXPECT_EQ(bench.loop.statistics().impacts, 2u);
}

// As physics tells them: one impact after the other, each step's input from the one before.
TEST(HapticLoop, ImpactsBetweenTwoTicksAreAllFeltAndThoseBeyondMemoryAreCounted) {
  for (const std::uint64_t impacts : {2u, 4u, 7u}) {
    HapticBench bench(without_ramp());
    for (int i = 0; i < 10; ++i) bench.live();
    HapticInput told = bench.message;
    scene::SceneState state;
    for (std::uint64_t number = 1; number <= impacts; ++number) {
      state.time = bench.now + bench.period;
      told = haptic_input(state, bench_impact(number, 0.5, bench.now + seconds(1e-4 * number)), told);
    }
    bench.message = told;
    for (int i = 0; i < 60; ++i) bench.live();
    const auto& s = bench.loop.statistics();
    const std::uint64_t felt = std::min<std::uint64_t>(impacts, 4);
    EXPECT_EQ(s.impacts, felt);
    EXPECT_EQ(s.missed_impacts, impacts - felt);
    EXPECT_EQ(s.rejected_impacts, 0u);
    EXPECT_NEAR(s.impulse_requested, felt * 0.0027 * 1.8 * 0.5, 1e-12);
    EXPECT_LT(s.lost_impulse_rel(), 1e-9);
  }
}

TEST(HapticLoop, ImpulseTheStartRampSwallowsIsCountedAsLost) {
  HapticBench bench;  // 1 s ramp
  bench.live();
  bench.message.impact = bench_impact(1, 2.0, bench.now);
  for (int i = 0; i < 60; ++i) bench.live();
  EXPECT_GT(bench.loop.statistics().lost_impulse_rel(), 0.9);
}

TEST(HapticLoop, AnImpactThatIsNoneIsRejected) {
  HapticBench bench(without_ramp());
  std::uint64_t number = 0;
  const auto reject = [&](auto&& spoil) {
    bench.message.impact = bench_impact(++number, 1.0, bench.now);
    spoil(bench.message.impact);
    bench.live();
    EXPECT_EQ(bench.loop.statistics().rejected_impacts, number);
  };
  reject([](scene::ImpactEvent& e) { e.mass = 0.0; });
  reject([](scene::ImpactEvent& e) { e.duration = Duration(0); });
  reject([](scene::ImpactEvent& e) { e.restitution = 1.5; });
  reject([](scene::ImpactEvent& e) { e.approach_speed = std::numeric_limits<double>::infinity(); });
  reject([](scene::ImpactEvent& e) { e.approach_speed = 1e300; });
  reject([](scene::ImpactEvent& e) { e.mass = 1e9; });
  reject([](scene::ImpactEvent& e) { e.duration = std::chrono::hours(1); });
  reject([](scene::ImpactEvent& e) { e.start = {Duration(std::numeric_limits<std::int64_t>::max())}; });
  reject([](scene::ImpactEvent& e) { e.direction.setZero(); });
  EXPECT_EQ(bench.loop.statistics().impacts, 0u);
}

TEST(HapticLoop, TheForceGainScalesImpactsAndSustainedForces) {
  HapticSettings settings = without_ramp();
  settings.force_gain = 0.5;
  HapticBench bench(settings);
  bench.message.continuous = {0.0, 1.0, 0.0};
  bench.live(20);
  EXPECT_NEAR((bench.arm.felt(bench_calibration()) - Vector3(0.0, 0.5, 0.0)).norm(), 0.0, 1e-9);
  bench.message.impact = bench_impact(1, 2.0, bench.now);
  bench.live(60);
  EXPECT_NEAR(bench.loop.statistics().impulse_requested, 0.5 * 0.0027 * 1.8 * 2.0, 1e-15);
  EXPECT_LT(bench.loop.statistics().impulse_error_rel_max, 1e-9);
}

TEST(HapticLoop, AtFourKilohertzTheImpulseIsTheSame) {
  HapticSettings settings = without_ramp();
  settings.period = Duration(250'000);
  HapticBench bench(settings);
  bench.live(5);
  bench.message.impact = bench_impact(1, 12.0, bench.now + seconds(0.0001));
  Vector3 impulse = Vector3::Zero();
  for (int i = 0; i < 200; ++i) {
    bench.live();
    impulse += 0.25e-3 * bench.arm.felt(bench_calibration());
  }
  const Vector3 requested = 0.0027 * 1.8 * 12.0 * bench.message.impact.direction;
  EXPECT_NEAR((impulse - requested).norm() / requested.norm(), 0.0, 1e-9);
  EXPECT_LE(bench.arm.steepest, 0.75 + 1e-9);
}

TEST(HapticLoop, ALongPushFallsToTheContinuousForceAndSaysSo) {
  HapticBench bench(without_ramp());
  bench.message.continuous = {0.0, 6.0, 0.0};
  bench.live(5000);
  double energy = 0.0;
  for (int i = 0; i < 5000; ++i) {
    bench.live();
    energy += bench.arm.force.squaredNorm();
  }
  EXPECT_NEAR(std::sqrt(energy / 5000), 1.4, 0.01);
  EXPECT_LT(bench.arm.steepest, 3.0 + 1e-9);
  EXPECT_EQ(bench.loop.state(), ForceState::degraded);
  EXPECT_EQ(bench.loop.fault(), ForceFault::none);
}

TEST(HapticLoop, AMovingArmStaysWithinTheDevicesOwnLimits) {
  // Impacts beyond peak and slew while the way from force to device changes in each tick.
  HapticBench bench(without_ramp());
  bench.arm.sample.joints = {0.0, 0.6, 0.6};
  bench.live(5);
  double requested = 0.0;
  for (int i = 0; i < 20000; ++i) {
    const double t = 1e-3 * i;
    bench.arm.sample.joints = {0.5 * std::sin(4.0 * t), 0.6 + 0.4 * std::sin(3.0 * t),
                               0.2 + 0.4 * std::cos(5.0 * t)};
    if (i % 400 == 0) {
      const double speed = 1.0 + i / 2000.0;
      bench.message.impact = bench_impact(static_cast<std::uint64_t>(i / 400 + 1), speed, bench.now);
      requested += 0.0027 * 1.8 * speed;
    }
    bench.live();
  }
  EXPECT_LE(bench.arm.largest, 8.5 * (1.0 + 1e-9));
  EXPECT_LE(bench.arm.steepest, 3.0 * (1.0 + 1e-9));
  EXPECT_GT(bench.arm.largest, 8.0);
  EXPECT_EQ(bench.loop.condition().trips, 0u);
  EXPECT_NEAR(bench.loop.statistics().impulse_requested, requested, 1e-9);
  EXPECT_LT(bench.loop.statistics().impulse_error_rel_max, 1e-6);
}

// A stylus of 75 g without a hand, thrown upwards at 0.3 m/s at a wall of 1000 N/m that the physics loop
// renders, one tick late; its kinetic energy when it has left, over that before.
double energy_after_a_stiff_wall(double most_damping) {
  HapticSettings settings = without_ramp();
  settings.limits.most_damping_n_s_m = most_damping;
  HapticBench bench(settings);
  const auto c = bench_calibration();
  const Vector3 wall =
      (c.X_world_base * device::phantom_tip(c.correction.apply({0.1, 0.5, 0.3}), c.model.lengths)).m;
  double x = -0.02, v = 0.3;
  for (int i = 0; i < 400 && !(x < -0.02 && v < 0.0); ++i) {
    Vector3 theta;
    const Point<ArmBase> tip = c.X_world_base.inverse() * Point<World>{wall + Vector3(0.0, x, 0.0)};
    EXPECT_TRUE(device::phantom_inverse(tip, c.model.lengths, theta));
    bench.arm.sample.joints = c.correction.undo(theta);
    bench.live();  // with the force of the tick before
    bench.message.continuous = {0.0, x > 0.0 ? -1000.0 * x : 0.0, 0.0};
    const double force = bench.arm.felt(c).y();
    for (int s = 0; s < 100; ++s) {
      v += 1e-5 / 0.075 * force;
      x += 1e-5 * v;
    }
  }
  return v * v / (0.3 * 0.3);
}

TEST(HapticLoop, AStiffWallGivesNoEnergyToTheHand) {
  EXPECT_GT(energy_after_a_stiff_wall(0.0), 1.3);
  // 3 % is the observer's allowance of 0.1 mJ.
  EXPECT_LT(energy_after_a_stiff_wall(ForceLimits{}.most_damping_n_s_m), 1.035);
}

TEST(HapticLoop, SettingsThatCannotBeAreRefused) {
  HapticSettings settings = bench_settings();
  settings.force_gain = 1.5;
  EXPECT_THROW(HapticBench{settings}, std::invalid_argument);
  settings = {};
  settings.period = Duration(0);
  EXPECT_THROW(HapticBench{settings}, std::invalid_argument);
  settings = {};
  settings.limits.peak_n = -1.0;
  EXPECT_THROW(HapticBench{settings}, std::invalid_argument);
}

TEST(HapticLoop, TickDoesNotAllocate) {
  HapticBench bench(without_ramp());
  Random random(1, "loop/alloc");
  bench.live();
  const std::size_t before = allocations();
  for (int i = 0; i < 3000; ++i) {
    if (i % 50 == 0) {
      bench.message.impact =
          bench_impact(static_cast<std::uint64_t>(i / 50 + 1), random.uniform(0.1, 20.0), bench.now);
    }
    if (i % 500 < 450) {
      bench.live();
    } else {
      bench.tick();  // faults must not allocate either
    }
  }
  EXPECT_EQ(allocations() - before, 0u);
}

#ifndef PALPATE_SANITIZED  // a sanitizer touches pages of its own
// What is touched for the first time in a tick costs a page fault there, microseconds or, from disk, milliseconds.
TEST(HapticLoop, NothingIsTouchedForTheFirstTimeInATick) {
  HapticBench bench;
  long faults = -1;
  std::thread([&] {
    enter_real_time(0);
    const auto so_far = [] {
      rusage used{};
      getrusage(RUSAGE_THREAD, &used);
      return used.ru_minflt + used.ru_majflt;
    };
    bench.message.continuous = {0.0, 1.0, 0.0};
    const long before = so_far();
    bench.live(2000);
    bench.arm.frozen = true;  // and on the ways that are gone seldom
    bench.live(20);
    bench.arm.sample.joints[0] = std::numeric_limits<double>::quiet_NaN();
    bench.live(20);
    faults = so_far() - before;
  }).join();
  EXPECT_EQ(faults, 0);
}
#endif

TEST(HapticLoop, TheLastSecondsAreKept) {
  HapticSettings settings = bench_settings();
  settings.record_s = 0.05;
  HapticBench bench(settings);
  for (int i = 0; i < 120; ++i) bench.live();
  const auto records = bench.loop.records();
  ASSERT_EQ(records.size(), 50u);
  EXPECT_EQ(records.back().time, bench.now);
  EXPECT_EQ(records.front().time, bench.now - Duration(49'000'000));
}

TEST(HapticInput, ThatComesLaterIsPlayedWholeAndLater) {
  HapticInput input;
  input.time = Instant<PhysicsClock>::from_seconds(1.0);
  input.impact = bench_impact(3, 1.0, Instant<PhysicsClock>::from_seconds(0.9));
  input.earlier[0] = bench_impact(2, 1.0, Instant<PhysicsClock>::from_seconds(0.8));
  const HapticInput out = later(input, std::chrono::milliseconds(40));
  EXPECT_NEAR(out.time.seconds(), 1.04, 1e-12)
      << "what comes out counts as of now: physics has not stood still";
  EXPECT_NEAR(out.impact.start.seconds(), 0.94, 1e-12);
  EXPECT_NEAR(out.earlier[0].start.seconds(), 0.84, 1e-12);
}

}  // namespace
}  // namespace palpate::haptics
