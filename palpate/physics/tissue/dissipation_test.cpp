#include "palpate/physics/tissue/dissipation.h"

#include <gtest/gtest.h>

#include <cmath>
#include <stdexcept>

#include "palpate/math/random_vector.h"

namespace palpate::physics::tissue {
namespace {

constexpr double kTick = 1e-3;

// A flat contact, its top at z = 0, of a spring of `tangent` along z.
TipEnergy flat_contact(double depth, double tangent = 200.0) {
  TipEnergy contact;
  contact.depth = depth;
  contact.tangent = tangent;
  contact.normal = Vector3::UnitZ();
  contact.force = tangent * depth * Vector3::UnitZ();
  contact.energy = 0.5 * tangent * depth * depth;
  return contact;
}

TEST(Dissipation, AtAConstantSpeedItIsADashpotOnceTheArmHasFollowed) {
  const DissipationSettings settings{.damping_n_s_m = 1.5};
  Dissipation dissipation(settings);
  Vector3 force;
  double depth = 0.002;
  for (int i = 0; i < 20; ++i) force = dissipation.step(flat_contact(depth += 1e-5), {0, 0, -1e-5}, kTick);
  EXPECT_NEAR(force.z(), 1.5 * 0.01, 1e-6) << "10 mm/s";
}

// The closed form of the arm's relaxation, by the implicit rule: a factor of 1 / (1 + T / tau) a tick.
TEST(Dissipation, HeldStillTheArmRelaxes) {
  const DissipationSettings settings{.damping_n_s_m = 1.0, .relaxation_s = 0.05};
  Dissipation dissipation(settings);
  const double first = dissipation.step(flat_contact(0.003), {0, 0, -1e-3}, kTick).z();
  EXPECT_NEAR(first, 20.0 * 1e-3 / 1.02, 1e-9);
  double force = first;
  for (int i = 0; i < 50; ++i) force = dissipation.step(flat_contact(0.003), Vector3::Zero(), kTick).z();
  EXPECT_NEAR(force, first * std::pow(1.0 / 1.02, 50), 1e-9);
  EXPECT_NEAR(dissipation.stored(), 0.5 * force * force / 20.0, 1e-12);
}

TEST(Dissipation, ItIsFadedInWithDepthNeverPullsAndIsBounded) {
  const DissipationSettings settings;
  Dissipation shallow(settings), deep(settings);
  EXPECT_LT(shallow.step(flat_contact(1e-6), {0, 0, -1e-5}, kTick).z(),
            0.01 * deep.step(flat_contact(1e-3), {0, 0, -1e-5}, kTick).z());
  const TipEnergy contact = flat_contact(0.002);
  const double out = contact.force.z() + deep.step(contact, {0, 0, 0.01}, kTick).z();
  EXPECT_GE(out, 0.0);
  EXPECT_LT(out, 1e-12) << "it does take off what it may";
  EXPECT_NEAR(deep.step(flat_contact(0.02), {0, 0, -0.02}, kTick).z(), settings.most_viscous_n, 1e-12);
}

TEST(Dissipation, AnEncodersStepChangesItByNoMoreThanIsStated) {
  const DissipationSettings settings;
  const double bound = viscous_step_bound(settings, 3e-5, kTick);
  EXPECT_LT(bound, 0.06) << "of a damper without the arm's spring";
  Dissipation dissipation(settings);
  Random random(1, "tissue/encoder");
  double before = 0.0;
  for (int i = 0; i < 10000; ++i) {
    const double way = 3e-5 * (static_cast<double>(random.below(3)) - 1.0);
    const double force = dissipation.step(flat_contact(0.003), {0, 0, way}, kTick).z();
    EXPECT_LE(std::abs(force - before), 2.0 * bound + 1e-12) << "a step back and forth";
    before = force;
  }
}

// Random motion, depth and stiffness: what was put in is never less than what is stored.
TEST(Dissipation, WhateverTheMotionItStoresNoMoreThanWasPutIn) {
  const DissipationSettings settings{.friction = 0.4};
  Random random(2, "tissue/passive");
  for (int run = 0; run < 100; ++run) {
    Dissipation dissipation(settings);
    double put_in = 0.0, depth = 0.002;
    Vector3 velocity = Vector3::Zero();
    for (int i = 0; i < 2000; ++i) {
      velocity = 0.98 * velocity + normal3(random, 0.004);
      const Vector3 way = kTick * velocity;
      depth = std::clamp(depth - way.z(), 1e-5, 0.006);
      TipEnergy contact = flat_contact(depth, 300.0 * std::sqrt(depth / 0.006));
      contact.normal = (Vector3::UnitZ() + 0.2 * std::sin(0.01 * i) * Vector3::UnitX()).normalized();
      contact.force = contact.force.z() * contact.normal;
      // The force of the tick's end over the tick's way: a spring stretched by it takes in more than it stores.
      put_in -= dissipation.step(contact, way, kTick).dot(way);
      ASSERT_GE(put_in, dissipation.stored() - 1e-12) << run << " " << i;
    }
    EXPECT_GT(put_in, 0.0);
  }
}

TEST(Dissipation, FrictionSticksBelowCoulombsLimitAndSlidesAtIt) {
  const DissipationSettings settings{.damping_n_s_m = 0.0, .friction = 0.3, .poisson = 0.45};
  Dissipation dissipation(settings);
  const TipEnergy contact = flat_contact(0.003);
  const double shear = 2.0 * 0.55 / 1.55 * contact.tangent, limit = 0.3 * contact.force.z();
  double aside = 0.0;
  Vector3 force;
  for (; shear * (aside + 1e-5) < limit; aside += 1e-5) {
    force = dissipation.step(contact, {1e-5, 0, 0}, kTick);
    ASSERT_FALSE(dissipation.sliding());
    ASSERT_NEAR(-force.x(), shear * (aside + 1e-5), 1e-9) << "Mindlin's spring";
    ASSERT_NEAR(dissipation.stored(), 0.5 * shear * std::pow(aside + 1e-5, 2), 1e-12);
  }
  for (int i = 0; i < 100; ++i) force = dissipation.step(contact, {1e-5, 0, 0}, kTick);
  EXPECT_TRUE(dissipation.sliding());
  EXPECT_NEAR(-force.x(), limit, 1e-12);
  force = dissipation.step(contact, {-1e-5, 0, 0}, kTick);
  EXPECT_FALSE(dissipation.sliding());
  EXPECT_NEAR(-force.x(), limit - shear * 1e-5, 1e-9) << "its anchor has been dragged along";
}

// The limit is a share of all that presses: of what the body's energy and the arm press with.
TEST(Dissipation, PressedQuicklyItHoldsMoreAndLiftedQuicklyLess) {
  const TipEnergy contact = flat_contact(0.003);
  for (const double down : {2e-5, -2e-5}) {
    Dissipation dissipation({.friction = 0.3});
    const Vector3 force = dissipation.step(contact, {0.005, 0.0, -down}, kTick);
    EXPECT_TRUE(dissipation.sliding());
    EXPECT_GT(std::abs(force.z()), 0.01);
    EXPECT_NEAR(force.head<2>().norm(), 0.3 * (contact.force.z() + force.z()), 1e-12);
  }
}

// With an arm that keeps its length for long, too.
TEST(Dissipation, HavingSlidItSticksAsSoonAsItTurnsBack) {
  Dissipation dissipation({.relaxation_s = 0.1, .friction = 0.3});
  const TipEnergy contact = flat_contact(0.003);
  for (int i = 0; i < 100; ++i) dissipation.step(contact, {1e-4, 0, 0}, kTick);
  EXPECT_TRUE(dissipation.sliding());
  dissipation.step(contact, {-1e-5, 0, 0}, kTick);
  EXPECT_FALSE(dissipation.sliding());
}

// Press, shear, press deeper, shear back, lift: with a spring whose length is kept this gives out energy.
TEST(Dissipation, PressingWhileShearedGivesOutNothing) {
  const DissipationSettings settings{.damping_n_s_m = 0.0, .friction = 2.0};
  Dissipation dissipation(settings);
  double put_in = 0.0, depth = 0.001;
  const auto go = [&](const Vector3& way, int ticks) {
    for (int i = 0; i < ticks; ++i) {
      depth -= way.z();
      put_in -= dissipation.step(flat_contact(depth, 100.0 + 4e4 * depth), way, kTick).dot(way);
    }
  };
  for (int cycle = 0; cycle < 20; ++cycle) {
    const double begun = put_in;
    go({1e-6, 0, 0}, 100);
    go({0, 0, -1e-5}, 300);
    go({-1e-6, 0, 0}, 100);
    go({0, 0, 1e-5}, 300);
    EXPECT_GE(put_in, begun - 1e-15) << cycle;
  }
}

TEST(Dissipation, SettingsThatMakeNoSenseAreRefused) {
  EXPECT_NO_THROW(Dissipation(DissipationSettings{}));
  EXPECT_THROW(Dissipation({.damping_n_s_m = -1.0}), std::invalid_argument);
  EXPECT_THROW(Dissipation({.relaxation_s = 0.0}), std::invalid_argument);
  EXPECT_THROW(Dissipation({.fade_m = std::nan("")}), std::invalid_argument);
  EXPECT_THROW(Dissipation({.friction = 3.0}), std::invalid_argument);
  EXPECT_THROW(Dissipation({.poisson = 0.6}), std::invalid_argument);
}

}  // namespace
}  // namespace palpate::physics::tissue
