#include "palpate/physics/tissue/two_contacts.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "palpate/math/random_vector.h"
#include "palpate/physics/tissue/tissue_for_tests.h"

namespace palpate::physics::tissue {
namespace {

constexpr double kYoung = 6000.0, kPoisson = 0.45;

const TipField& shared_body() {
  static const TipField field = *block_for_tests({.share = bump_for_tests({0.01, 0.0, 0.02}, 0.3, 0.01)});
  return field;
}
MutualCompliance between(const Vector3& first, const Vector3& second) {
  return half_space_compliance(first, second, kYoung, kPoisson, 0.005);
}
TwoForces press_two(const Vector3& first, const Vector3& second) {
  return two_contacts(shared_body(), first, shared_body(), second, between(first, second));
}
Vector3 pressed_at(double x, double depth) { return {x, 0.004, 0.028 - depth}; }

TEST(TwoContacts, FarApartOrAloneEachIsAsIfAlone) {
  const Vector3 first = pressed_at(-0.01, 0.004), air(0.02, 0.004, 0.05);
  const TwoForces alone = press_two(first, air);
  EXPECT_LT((alone.first - shared_body().at(first).force).norm(), 1e-12);
  EXPECT_EQ(alone.second, Vector3::Zero());
  EXPECT_NEAR(alone.energy, shared_body().at(first).energy, 1e-15);
  const TwoForces none = two_contacts(shared_body(), first, shared_body(), pressed_at(0.02, 0.003), {});
  EXPECT_LT((none.second - shared_body().at(pressed_at(0.02, 0.003)).force).norm(), 1e-12);
}

// The equations of the two depths, by bisection of one within the other.
TEST(TwoContacts, TheDepthsLeftSolveTheirEquations) {
  for (const double apart : {0.01, 0.015, 0.03}) {
    const Vector3 first = pressed_at(-0.5 * apart, 0.004), second = pressed_at(0.5 * apart, 0.005);
    const TwoForces found = press_two(first, second);
    const auto own = [](const Vector3& p, double delta) {
      const auto [d, kappa] = shared_body().fields().sample(p);
      return 2.5 * kappa.value * std::pow(delta, 1.5);
    };
    const double c = between(first, second).value;
    const auto second_of = [&](double x) { return std::max(0.0, 0.005 - c * own(first, x)); };
    double low = 0.0, high = 0.004;
    for (int i = 0; i < 60; ++i) {
      const double x = 0.5 * (low + high);
      (x + c * own(second, second_of(x)) > 0.004 ? high : low) = x;
    }
    // The lattice has a depth of its own, within 0.2 um of the geometry's.
    EXPECT_NEAR(found.first_depth, low, 2e-7) << apart;
    EXPECT_NEAR(found.second_depth, second_of(low), 2e-7);
    EXPECT_LT(found.first_depth, 0.004);
  }
}

// The dent of the deeper one is deeper here than the other one reaches.
TEST(TwoContacts, WhatReachesLessDeepThanTheOthersDentTouchesNothing) {
  const Vector3 shallow = pressed_at(-0.003, 0.0003), deep = pressed_at(0.003, 0.005);
  const TipEnergy alone = shared_body().at(deep);
  ASSERT_GT(between(shallow, deep).value * alone.force.norm(), 2.0 * 0.0003);
  const TwoForces found = press_two(shallow, deep), exchanged = press_two(deep, shallow);
  EXPECT_EQ(found.first_depth, 0.0);
  EXPECT_EQ(found.first.norm(), 0.0);
  EXPECT_LT((found.second - alone.force).norm(), 1e-12);
  EXPECT_NEAR(found.energy, alone.energy, 1e-15);
  EXPECT_EQ(exchanged.second_depth, 0.0);
  EXPECT_LT((exchanged.first - alone.force).norm(), 1e-12);
}

// There Newton's rule alone leads away from any solution. The one that is found has the deeper one's contact alone.
TEST(TwoContacts, WhereEachGivesWayMoreThanTheOtherResistsTheDeeperOneStays) {
  for (const double compliance : {0.02, 0.03, 0.045})
    for (const double less : {0.001, 0.0015}) {
      const Vector3 first = pressed_at(-0.015, 0.0045 - less), second = pressed_at(-0.01, 0.0045);
      const TwoForces found =
          two_contacts(shared_body(), first, shared_body(), second, {compliance, Vector3::Zero()});
      EXPECT_EQ(found.first_depth, 0.0) << compliance << ' ' << less;
      EXPECT_NEAR(found.second_depth, 0.0045, 2e-7);
      EXPECT_LT((found.second - shared_body().at(second).force).norm(), 1e-12);
    }
}

// Whatever the compliance: a servo gets finite forces, and nobody is deeper than its place is.
TEST(TwoContacts, DepthsStayWithinThoseOfTheirPlaces) {
  Random random(2, "tissue/two contacts/any compliance");
  for (int i = 0; i < 2000; ++i) {
    const double depth_1 = random.uniform(0.0001, 0.005);
    const double depth_2 = random.uniform(0.0001, 0.005);
    const double compliance = std::pow(10.0, random.uniform(-4.0, 2.0));
    const TwoForces found = two_contacts(shared_body(), pressed_at(-0.01, depth_1), shared_body(),
                                         pressed_at(0.01, depth_2), {compliance, Vector3::Zero()});
    ASSERT_TRUE(found.first.allFinite() && found.second.allFinite() && std::isfinite(found.energy));
    ASSERT_GE(std::min(found.first_depth, found.second_depth), 0.0);
    ASSERT_LT(found.first_depth, depth_1 + 1e-6) << compliance;
    ASSERT_LT(found.second_depth, depth_2 + 1e-6) << compliance;
  }
}

TEST(TwoContacts, ForcesAreTheGradientOfTheSharedEnergyByBothPlaces) {
  Random random(1, "tissue/two contacts");
  for (int i = 0; i < 300; ++i) {
    const Vector3 first = pressed_at(random.uniform(-0.02, -0.008), random.uniform(0.0005, 0.005));
    const Vector3 second = pressed_at(random.uniform(0.004, 0.02), random.uniform(0.0005, 0.005));
    const TwoForces here = press_two(first, second);
    for (Eigen::Index k = 0; k < 3; ++k) {
      const Vector3 step = 1e-7 * Vector3::Unit(k);
      const double by_first =
          (press_two(first + step, second).energy - press_two(first - step, second).energy) / 2e-7;
      const double by_second =
          (press_two(first, second + step).energy - press_two(first, second - step).energy) / 2e-7;
      EXPECT_NEAR(here.first[k], -by_first, 1e-6 + 1e-5 * here.first.norm());
      EXPECT_NEAR(here.second[k], -by_second, 1e-6 + 1e-5 * here.second.norm());
    }
  }
}

TEST(TwoContacts, ExchangedTheyAreTheSame) {
  const Vector3 first = pressed_at(-0.007, 0.003), second = pressed_at(0.008, 0.005);
  const TwoForces one = press_two(first, second), other = press_two(second, first);
  EXPECT_NEAR(one.energy, other.energy, 1e-15);
  EXPECT_LT((one.first - other.second).norm(), 1e-12);
}

// Boussinesq: a point load's dent at a distance.
TEST(TwoContacts, TheHalfSpacesComplianceIsBoussinesqsAndItsGradientIsRight) {
  const Vector3 first(0.0, 0.0, 0.0), second(0.05, 0.0, 0.0);
  const MutualCompliance far = half_space_compliance(first, second, kYoung, kPoisson, 1e-6);
  EXPECT_NEAR(far.value, (1.0 - 0.45 * 0.45) / (std::numbers::pi * 6000.0 * 0.05), 1e-9);
  for (Eigen::Index k = 0; k < 3; ++k) {
    const Vector3 at(0.01, -0.004, 0.002), step = 1e-7 * Vector3::Unit(k);
    const double slope = (between(at + step, second).value - between(at - step, second).value) / 2e-7;
    EXPECT_NEAR(between(at, second).gradient[k], slope, 1e-6 * std::abs(slope) + 1e-9);
  }
}

}  // namespace
}  // namespace palpate::physics::tissue
