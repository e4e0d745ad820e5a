#include "palpate/haptics/force_limiter.h"

#include <gtest/gtest.h>

#include <cmath>

#include "palpate/core/random.h"
#include "palpate/math/random_vector.h"
#include "palpate/physics/contact.h"

namespace palpate::haptics {
namespace {

constexpr double kTick = 0.001, kPeak = 8.5, kStep = 3.0;
const AvailableForce kRoom{.peak = kPeak, .step = kStep};

struct Delivered {
  double impulse = 0.0, peak = 0.0, steepest = 0.0, longest = 0.0;
};

// An impact on the limiter, tick by tick, until all of it has been given.
Delivered play(ForceLimiter& limiter, double speed, double duration, double tick, double phase) {
  const physics::DampedContact contact(0.0027, 0.8, duration, physics::Release::where_force_is_zero);
  const AvailableForce available{.peak = kPeak, .step = kStep * tick / kTick};
  Delivered d;
  Vector3 last = Vector3::Zero();
  for (int i = 0; i < static_cast<int>(0.3 / tick); ++i) {
    const double from = i * tick - phase, to = from + tick;
    RequestedForce requested;
    requested.impact = speed * contact.mean_force(from, to) * Vector3::UnitZ();
    requested.impact_active = to < duration;
    requested.impact_to_come = speed * 0.0027 * (contact.velocity(to) + 0.8) * Vector3::UnitZ();
    const Vector3 f = limiter.tick(requested, available, tick, tick);
    d.impulse += f.z() * tick;
    d.peak = std::max(d.peak, f.norm());
    d.steepest = std::max(d.steepest, (f - last).norm());
    if (f.norm() > 0.0) d.longest = to;
    last = f;
  }
  return d;
}

TEST(ForceLimiter, AnImpactBeyondPeakAndSlewIsHeldLongerAndLosesNothing) {
  for (const double tick : {0.001, 0.00025})
    for (const double speed : {0.1, 1.0, 3.0, 5.0, 10.0, 20.0})
      for (const double duration : {0.001, 0.004})
        for (const double phase : {0.0, 0.31e-3, 0.77e-3}) {
          ForceLimiter limiter(0.1);
          const auto d = play(limiter, speed, duration, tick, std::min(phase, tick));
          EXPECT_NEAR(d.impulse / (0.0027 * 1.8 * speed), 1.0, 1e-9) << speed << " " << tick;
          EXPECT_LE(d.peak, kPeak + 1e-12);
          EXPECT_LE(d.steepest, kStep * tick / kTick + 1e-9);
          EXPECT_TRUE(limiter.settled());
          EXPECT_LT(limiter.lost().norm(), 1e-12);
        }
  ForceLimiter limiter(0.1);
  // 20 m/s: 97 mN s at 8.5 N is 11.4 ms, and the slopes of 3 N/ms add about 3 ms.
  EXPECT_NEAR(play(limiter, 20.0, 0.004, kTick, 0.0).longest, 0.0145, 0.002);
}

TEST(ForceLimiter, AGentleImpactPassesUntouched) {
  ForceLimiter limiter(0.1);
  const physics::DampedContact contact(0.0027, 0.8, 0.004, physics::Release::where_force_is_zero);
  for (int i = 0; i < 8; ++i) {
    RequestedForce requested;
    requested.impact = contact.mean_force(i * kTick, (i + 1) * kTick) * Vector3::UnitX();
    requested.impact_to_come = 0.0027 * (contact.velocity((i + 1) * kTick) + 0.8) * Vector3::UnitX();
    requested.impact_active = i < 3;
    EXPECT_NEAR((limiter.tick(requested, kRoom, kTick, kTick) - requested.impact).norm(), 0.0, 1e-9);
    EXPECT_FALSE(limiter.limited());
  }
}

TEST(ForceLimiter, UnevenTicksAreMadeUpFor) {
  Random random(1, "shaper/jitter");
  ForceLimiter limiter(0.1);
  const physics::DampedContact contact(0.0027, 0.8, 0.004, physics::Release::where_force_is_zero);
  double t = 0.0, elapsed = 0.0, impulse = 0.0, played = 0.0;
  for (int i = 0; i < 200; ++i) {
    const double until = std::min(t + kTick, 0.004);
    RequestedForce requested;
    if (until > played) {
      requested.impact =
          3.0 * contact.mean_force(played, until) * (until - played) / kTick * Vector3::UnitZ();
      played = until;
    }
    requested.impact_to_come = 3.0 * 0.0027 * (contact.velocity(played) + 0.8) * Vector3::UnitZ();
    requested.impact_active = played < 0.004;
    const Vector3 f = limiter.tick(requested, kRoom, elapsed, kTick);
    elapsed = kTick * random.uniform(0.8, 1.3);
    impulse += f.z() * elapsed;
    t += elapsed;
  }
  EXPECT_NEAR(impulse / (0.0027 * 1.8 * 3.0), 1.0, 1e-9);
}

TEST(ForceLimiter, ImpactsOnTopOfASustainedForceArriveWhole) {
  Random random(4, "shaper/both");
  for (int run = 0; run < 200; ++run) {
    ForceLimiter limiter(0.1);
    const Vector3 continuous = normal3(random, 1.0);
    RequestedForce requested;
    requested.continuous = continuous;
    for (int i = 0; i < 20; ++i) limiter.tick(requested, kRoom, kTick, kTick);
    const Vector3 start = limiter.held();
    Vector3 impulse = Vector3::Zero(), impacts = Vector3::Zero(), last = start;
    for (int i = 0; i < 300; ++i) {
      requested.impact = i < 12 && random.chance(0.5) ? normal3(random, 8.0) : Vector3::Zero();
      impacts += kTick * requested.impact;
      requested.impact_active = i < 12;
      const Vector3 f = limiter.tick(requested, kRoom, kTick, kTick);
      impulse += kTick * (f - continuous);
      ASSERT_LE(f.norm(), kPeak * (1.0 + 1e-12));
      ASSERT_LE((f - last).norm(), kStep * (1.0 + 1e-12));
      last = f;
    }
    EXPECT_NEAR((impulse - impacts).norm(), 0.0, 1e-6 * impacts.norm()) << run;
    EXPECT_TRUE(limiter.settled());
  }
}

TEST(ForceLimiter, ASustainedForceIsClampedAndSlewed) {
  ForceLimiter limiter(0.1);
  RequestedForce requested;
  requested.continuous = {20.0, 0.0, 0.0};
  EXPECT_NEAR(limiter.tick(requested, kRoom, kTick, kTick).x(), 3.0, 1e-12);
  EXPECT_TRUE(limiter.limited());
  for (int i = 0; i < 10; ++i) limiter.tick(requested, kRoom, kTick, kTick);
  EXPECT_NEAR(limiter.tick(requested, kRoom, kTick, kTick).x(), 8.5, 1e-12);
  EXPECT_LT(limiter.delivered().norm(), 1e-15) << "none of it is a blow's";
}

TEST(ForceLimiter, WhatAFaultCutsOffIsCountedAndNotPaidLater) {
  ForceLimiter limiter(0.1);
  RequestedForce requested;
  requested.impact = {40.0, 0.0, 0.0};
  requested.impact_active = true;
  limiter.tick(requested, kRoom, kTick, kTick);
  requested.impact.setZero();
  requested.impact_active = false;
  for (int i = 14; i >= 0; --i)
    limiter.tick(requested, {.peak = kPeak, .step = kStep, .gain = i / 15.0, .fading = true}, kTick, kTick);
  EXPECT_EQ(limiter.held().norm(), 0.0);
  EXPECT_LT(limiter.delivered().x(), 0.040);
  EXPECT_NEAR(limiter.delivered().x() + limiter.lost().x(), 0.040, 1e-12);
  for (int i = 0; i < 50; ++i) EXPECT_EQ(limiter.tick({}, kRoom, kTick, kTick).norm(), 0.0);
}

TEST(ForceLimiter, AForceHeldTooLongByALoopThatStoodStillIsNotPulledBack) {
  ForceLimiter limiter(0.1);
  RequestedForce requested;
  requested.impact = {3.0, 0.0, 0.0};
  requested.impact_active = true;
  limiter.tick(requested, kRoom, kTick, kTick);
  AvailableForce available = kRoom;
  available.drop_backlog = true;
  limiter.tick({}, available, 0.2, kTick);  // 3 N for 200 ms: 0.6 N s instead of 3 mN s
  for (int i = 0; i < 100; ++i) EXPECT_GE(limiter.tick({}, kRoom, kTick, kTick).x(), 0.0);
}

// Peak and slew as the arm's pose and the motors' heat leave them, other ones in each tick: what the limiter
// planned with no longer holds while there is a backlog.
TEST(ForceLimiter, LimitsThatChangeWhileImpulseIsOwedLoseNoneOfIt) {
  Random random(6, "shaper/room");
  const physics::DampedContact contact(0.0027, 0.8, 0.004, physics::Release::where_force_is_zero);
  double most_pulled = 0.0;  // backwards, where limits fall steadily
  for (int run = 0; run < 300; ++run) {
    ForceLimiter limiter(0.1);
    const double speed = random.uniform(0.5, 10.0);
    const Vector3 along = normal3(random, 1.0).normalized();
    const bool by_leaps = run % 2 == 0;  // else they fall steadily, to a fifth
    Vector3 impulse = Vector3::Zero(), last = Vector3::Zero();
    for (int i = 0; i < 300; ++i) {
      const double from = i * kTick, to = from + kTick;
      RequestedForce requested;
      requested.impact = speed * contact.mean_force(from, to) * along;
      requested.impact_active = to < 0.004;
      requested.impact_to_come = speed * 0.0027 * (contact.velocity(to) + 0.8) * along;
      const double share = by_leaps ? random.uniform(0.2, 1.0) : std::max(0.2, 1.0 - 0.05 * i);
      const AvailableForce available{.peak = share * kPeak, .step = share * kStep};
      const Vector3 f = limiter.tick(requested, available, kTick, kTick);
      ASSERT_LE((f - last).norm(), available.step * (1.0 + 1e-9));
      impulse += kTick * f;
      if (!by_leaps) most_pulled = std::max(most_pulled, -f.dot(along));
      last = f;
    }
    const double whole = 0.0027 * 1.8 * speed;
    EXPECT_TRUE(limiter.settled());
    EXPECT_NEAR((impulse - whole * along).norm(), 0.0, 1e-6 * whole) << run;
    EXPECT_LT(limiter.lost().norm(), 1e-6 * whole) << run;
  }
  // Where the step grows smaller on the way down, more is given than the backlog was, and is taken back: 1.1
  // N for impacts of up to 10 m/s and limits that lose a twentieth in each tick.
  EXPECT_LT(most_pulled, 1.5);
}

TEST(ForceLimiter, WhereTheLimitsLeaveTooLittleTheLossIsReported) {
  ForceLimiter limiter(0.1);
  RequestedForce requested;
  requested.impact = {40.0, 0.0, 0.0};
  Vector3 impulse = Vector3::Zero();
  for (int i = 0; i < 400; ++i) {
    requested.impact_active = i == 0;
    // 40 mN s were the backlog when the peak fell to what can give 10 of them in 100 ms.
    const AvailableForce available{.peak = i < 2 ? kPeak : 0.1, .step = kStep};
    impulse += kTick * limiter.tick(requested, available, kTick, kTick);
    requested.impact.setZero();
  }
  EXPECT_TRUE(limiter.settled());
  EXPECT_GT(limiter.lost().x(), 0.010);
  EXPECT_NEAR(impulse.x() + limiter.lost().x(), 0.040, 1e-12);
}

TEST(ForceLimiter, AForceThatPullsAtItsEndComesAsItIs) {
  ForceLimiter limiter(0.1);
  const double course[] = {1.0, 2.0, 0.5, -0.3};  // N
  for (int i = 0; i < 5; ++i) {
    RequestedForce requested;
    if (i < 4) requested.impact.x() = course[i];
    for (int k = i + 1; k < 4; ++k) requested.impact_to_come.x() += kTick * course[k];
    requested.impact_active = i < 3;
    EXPECT_NEAR(limiter.tick(requested, kRoom, kTick, kTick).x(), requested.impact.x(), 1e-12);
    EXPECT_FALSE(limiter.limited());
  }
}

TEST(ForceLimiter, AskedIsAlwaysDeliveredOwedOrLost) {
  Random random(5, "shaper/books");
  ForceLimiter limiter(0.02);
  Vector3 requested_sum = Vector3::Zero();
  double turned_over = 0.0, elapsed = 0.0;
  for (int i = 0; i < 200000; ++i) {
    RequestedForce requested;
    if (random.chance(0.1)) requested.impact = normal3(random, 20.0);
    if (random.chance(0.5)) requested.continuous = normal3(random, 4.0);
    requested.impact_active = random.chance(0.3);
    requested.impact_to_come = requested.impact_active ? normal3(random, 0.01) : Vector3::Zero();
    const AvailableForce available{.peak = random.uniform(1.0, 8.5),
                                   .step = random.uniform(-0.1, 3.0),
                                   .gain = random.uniform(0.0, 1.0),
                                   .fading = random.chance(0.1),
                                   .drop_backlog = random.chance(0.01)};
    const Vector3 before = limiter.held();
    const Vector3 f = limiter.tick(requested, available, elapsed, kTick);
    requested_sum += kTick * requested.impact;
    turned_over += kTick * requested.impact.norm();
    ASSERT_LE((f - before).norm(), std::max(available.step, 0.0) + 1e-11);
    elapsed = random.uniform(0.0, 0.003);
    if (i % 1000 == 0) {
      ASSERT_LT((requested_sum - limiter.delivered() - limiter.backlog() - limiter.lost()).norm(),
                1e-12 * (1.0 + turned_over));
    }
  }
}

TEST(ForceLimiter, ForcesThatAreNoneAreNotGood) {
  const double infinite = std::numeric_limits<double>::infinity();
  for (const double bad : {std::nan(""), infinite, -infinite, 1e300, 2e6}) {
    RequestedForce requested;
    EXPECT_TRUE(requested.good());
    requested.continuous.y() = bad;
    EXPECT_FALSE(requested.good());
    requested = {};
    requested.impact.z() = bad;
    EXPECT_FALSE(requested.good());
    requested = {};
    requested.impact_to_come.x() = bad;
    EXPECT_FALSE(requested.good());
  }
}

}  // namespace
}  // namespace palpate::haptics
