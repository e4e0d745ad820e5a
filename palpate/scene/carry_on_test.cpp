#include "palpate/scene/carry_on.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace palpate::scene {
namespace {

struct Carried;

struct CarriedMotion {
  Instant<PhysicsClock> time{Duration(std::chrono::seconds(2))};
  Vector3 velocity{0.1, 0.0, -0.2};
  Vector3 spin{0.0, 50.0 * std::numbers::pi, 0.0};  // a quarter turn in 10 ms
};

Pose<World, Carried> where_it_was() { return {Quaternion::Identity(), Vector3(1.0, 2.0, 3.0)}; }

TEST(CarryOn, MovesAndTurnsAsFastAsTheBodyDid) {
  const CarriedMotion motion;
  const auto X = carried_on(where_it_was(), motion, motion.time + std::chrono::milliseconds(2));
  EXPECT_LT((X.translation - Vector3(1.0002, 2.0, 2.9996)).norm(), 1e-12);
  const double angle = 0.1 * std::numbers::pi;
  EXPECT_LT((X.rotation * Vector3::UnitX() - Vector3(std::cos(angle), 0.0, -std::sin(angle))).norm(), 1e-12);
}

TEST(CarryOn, NeitherBackNorFurtherThanAStandingLoopAllows) {
  const CarriedMotion motion;
  const auto before = carried_on(where_it_was(), motion, motion.time - std::chrono::milliseconds(2));
  EXPECT_EQ(before.translation, where_it_was().translation);
  const auto late = carried_on(where_it_was(), motion, motion.time + std::chrono::seconds(1));
  EXPECT_LT((late.translation - Vector3(1.0003, 2.0, 2.9994)).norm(), 1e-12);
}

TEST(CarryOn, WhatRestsStaysToTheLastBit) {
  CarriedMotion still;
  still.velocity.setZero();
  still.spin.setZero();
  Pose<World, Carried> X = where_it_was();
  X.rotation = Quaternion(0.3, 0.1, 0.7, 0.2);  // not quite unit: it would be normalised
  EXPECT_EQ(carried_on(X, still, still.time + std::chrono::milliseconds(1)).rotation.coeffs(),
            X.rotation.coeffs());
}

}  // namespace
}  // namespace palpate::scene
