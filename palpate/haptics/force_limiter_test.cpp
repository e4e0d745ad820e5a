#include "palpate/haptics/force_limiter.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "palpate/core/random.h"
#include "palpate/physics/contact.h"

namespace palpate {
namespace {

constexpr double kTick = 0.001;

ForceLimits at_once() {
  ForceLimits limits;
  limits.start_ramp_s = 0.0;
  return limits;
}

struct Delivered {
  double impulse = 0.0, peak = 0.0, steepest = 0.0, longest = 0.0;
};

// A blow on the limiter, tick by tick, until it is paid.
Delivered play(ForceLimiter& limiter, double speed, double duration) {
  const DampedContact contact(0.0027, 0.8, duration, Release::where_force_is_zero);
  Delivered d;
  Vector3 last = Vector3::Zero();
  for (int i = 0; i < 300; ++i) {
    AskedForce asked;
    asked.blow = speed * contact.mean_force(i * kTick, (i + 1) * kTick) * Vector3::UnitZ();
    asked.blow_active = (i + 1) * kTick < duration;
    asked.blow_to_come = speed * 0.0027 * (contact.velocity((i + 1) * kTick) + 0.8) * Vector3::UnitZ();
    const Vector3 f = limiter.tick(asked, kTick, kTick);
    d.impulse += f.z() * kTick;
    d.peak = std::max(d.peak, f.norm());
    d.steepest = std::max(d.steepest, (f - last).norm());
    if (f.norm() > 0.0) d.longest = (i + 1) * kTick;
    last = f;
  }
  return d;
}

TEST(ForceLimiter, ABlowBeyondThePeakIsHeldLongerAndLosesNothing) {
  for (const double speed : {0.1, 1.0, 3.0, 5.0, 10.0, 20.0}) {
    for (const double duration : {0.001, 0.004}) {
      ForceLimiter limiter(at_once());
      const auto d = play(limiter, speed, duration);
      EXPECT_NEAR(d.impulse / (0.0027 * 1.8 * speed), 1.0, 1e-9) << speed;
      EXPECT_LE(d.peak, 8.5 + 1e-12);
      EXPECT_LE(d.steepest, 3.0 + 1e-9);
      EXPECT_TRUE(limiter.settled());
    }
  }
  ForceLimiter limiter(at_once());
  // 20 m/s: 97 mN s at 8.5 N is 11.4 ms, and the slopes of 3 N/ms add about 3 ms.
  EXPECT_NEAR(play(limiter, 20.0, 0.004).longest, 0.0145, 0.002);
}

TEST(ForceLimiter, AGentleBlowPassesUntouched) {
  ForceLimiter limiter(at_once());
  const DampedContact contact(0.0027, 0.8, 0.004, Release::where_force_is_zero);
  for (int i = 0; i < 8; ++i) {
    AskedForce asked;
    asked.blow = contact.mean_force(i * kTick, (i + 1) * kTick) * Vector3::UnitX();
    asked.blow_to_come = 0.0027 * (contact.velocity((i + 1) * kTick) + 0.8) * Vector3::UnitX();
    asked.blow_active = i < 3;
    EXPECT_NEAR((limiter.tick(asked, kTick, kTick) - asked.blow).norm(), 0.0, 1e-9);
    EXPECT_FALSE(limiter.limited());
  }
}

TEST(ForceLimiter, UnevenTicksAreMadeUpFor) {
  Random random(1, "limiter/jitter");
  ForceLimiter limiter(at_once());
  const DampedContact contact(0.0027, 0.8, 0.004, Release::where_force_is_zero);
  double t = 0.0, elapsed = 0.0, impulse = 0.0, played = 0.0;
  for (int i = 0; i < 200; ++i) {
    const double until = std::min(t + kTick, 0.004);
    AskedForce asked;
    if (until > played) {
      asked.blow = 3.0 * contact.mean_force(played, until) * (until - played) / kTick * Vector3::UnitZ();
      played = until;
    }
    asked.blow_to_come = 3.0 * 0.0027 * (contact.velocity(played) + 0.8) * Vector3::UnitZ();
    asked.blow_active = played < 0.004;
    const Vector3 f = limiter.tick(asked, elapsed, kTick);
    elapsed = kTick * random.uniform(0.8, 1.3);
    impulse += f.z() * elapsed;
    t += elapsed;
  }
  EXPECT_NEAR(impulse / (0.0027 * 1.8 * 3.0), 1.0, 1e-9);
}

TEST(ForceLimiter, SustainedForceIsClampedAndSlewed) {
  ForceLimits limits = at_once();
  limits.continuous_n = 100.0;
  ForceLimiter limiter(limits);
  AskedForce asked;
  asked.sustained = {20.0, 0.0, 0.0};
  EXPECT_NEAR(limiter.tick(asked, kTick, kTick).x(), 3.0, 1e-12);
  EXPECT_TRUE(limiter.limited());
  for (int i = 0; i < 10; ++i) limiter.tick(asked, kTick, kTick);
  EXPECT_NEAR(limiter.tick(asked, kTick, kTick).x(), 8.5, 1e-12);
}

TEST(ForceLimiter, ALongPushFallsToTheContinuousForce) {
  ForceLimiter limiter(at_once());
  AskedForce asked;
  asked.sustained = {6.0, 0.0, 0.0};
  double energy = 0.0;
  for (int i = 0; i < 10000; ++i) {
    const double f = limiter.tick(asked, kTick, kTick).norm();
    if (i >= 5000) energy += f * f;
  }
  EXPECT_NEAR(std::sqrt(energy / 5000), 1.4, 0.1);
}

TEST(ForceLimiter, ForceStartsAlongARamp) {
  ForceLimiter limiter;
  AskedForce asked;
  asked.sustained = {1.0, 0.0, 0.0};
  for (int i = 0; i < 250; ++i) limiter.tick(asked, kTick, kTick);
  EXPECT_NEAR(limiter.tick(asked, kTick, kTick).x(), 0.25, 0.005);
  for (int i = 0; i < 1000; ++i) limiter.tick(asked, kTick, kTick);
  EXPECT_NEAR(limiter.tick(asked, kTick, kTick).x(), 1.0, 1e-12);
}

TEST(ForceLimiter, StaleInputFadesWithoutAJumpAndComesBackAlongTheRamp) {
  ForceLimiter limiter(at_once());
  AskedForce asked;
  asked.sustained = {1.2, 0.0, 0.0};
  limiter.tick(asked, kTick, kTick);
  asked.input_age_s = 0.0051;
  double last = 1.2;
  for (int i = 0; i < 20; ++i) {
    const double f = limiter.tick(asked, kTick, kTick).x();
    EXPECT_EQ(limiter.fault(), ForceFault::stale_input);
    EXPECT_LE(std::abs(last - f), 1.2 / 20 + 1e-9);
    last = f;
  }
  EXPECT_NEAR(last, 0.0, 1e-9);
  asked.input_age_s = 0.0;
  limiter.tick(asked, kTick, kTick);
  EXPECT_EQ(limiter.fault(), ForceFault::none);
}

TEST(ForceLimiter, WhatAFaultCutsOffIsNotPaidLater) {
  ForceLimiter limiter(at_once());
  AskedForce asked;
  asked.blow = {40.0, 0.0, 0.0};
  limiter.tick(asked, kTick, kTick);
  asked.blow.setZero();
  asked.input_age_s = 1.0;
  for (int i = 0; i < 40; ++i) limiter.tick(asked, kTick, kTick);
  EXPECT_TRUE(limiter.settled());
  EXPECT_LT(limiter.delivered().norm(), 0.040);
  asked.input_age_s = 0.0;
  EXPECT_EQ(limiter.tick(asked, kTick, kTick).norm(), 0.0);
}

TEST(ForceLimiter, NumbersThatAreNoneGiveNoForce) {
  for (const double bad : {std::nan(""), std::numeric_limits<double>::infinity()}) {
    ForceLimiter limiter(at_once());
    AskedForce asked;
    asked.sustained = {bad, 1.0, 0.0};
    EXPECT_EQ(limiter.tick(asked, kTick, kTick).norm(), 0.0);
    EXPECT_EQ(limiter.fault(), ForceFault::not_finite);
    asked = {};
    asked.blow = {0.0, bad, 0.0};
    EXPECT_EQ(limiter.tick(asked, kTick, kTick).norm(), 0.0);
    asked = {};
    EXPECT_TRUE(limiter.tick(asked, kTick, kTick).allFinite());
    EXPECT_EQ(limiter.fault(), ForceFault::none);
  }
}

TEST(ForceLimiter, AnArmThatRunsAwayStaysOffUntilRearmed) {
  ForceLimiter limiter(at_once());
  AskedForce asked;
  asked.sustained = {1.0, 0.0, 0.0};
  asked.tip_speed = 5.0;
  for (int i = 0; i < 30; ++i) limiter.tick(asked, kTick, kTick);
  asked.tip_speed = 0.0;
  EXPECT_EQ(limiter.tick(asked, kTick, kTick).norm(), 0.0);
  EXPECT_EQ(limiter.fault(), ForceFault::overspeed);
  limiter.rearm();
  EXPECT_GT(limiter.tick(asked, kTick, kTick).norm(), 0.0);
}

TEST(ForceLimiter, NeverAboveThePeakWhateverIsAsked) {
  Random random(2, "limiter/any");
  ForceLimiter limiter(at_once());
  const auto vector = [&](double size) {
    return Vector3(random.normal(size), random.normal(size), random.normal(size));
  };
  for (int i = 0; i < 20000; ++i) {
    AskedForce asked;
    asked.sustained = vector(random.chance(0.01) ? 1e6 : 3.0);
    asked.blow = vector(random.chance(0.05) ? 50.0 : 0.0);
    asked.blow_to_come = vector(0.01);
    asked.input_age_s = random.chance(0.05) ? 1.0 : 0.0;
    const Vector3 f = limiter.tick(asked, kTick, kTick);
    ASSERT_TRUE(f.allFinite());
    ASSERT_LE(f.norm(), 8.5 + 1e-9);
  }
}

TEST(ForceLimiter, ImpossibleLimitsAreRefused) {
  ForceLimits limits;
  limits.peak_n = 0.0;
  EXPECT_THROW(ForceLimiter{limits}, std::invalid_argument);
}

}  // namespace
}  // namespace palpate
