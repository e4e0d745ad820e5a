#include "palpate/sim/delta_arm.h"

#include <gtest/gtest.h>

#include "palpate/core/random.h"

namespace palpate::sim {
namespace {

Vector3 somewhere(Random& random) {
  return {random.uniform(-0.3, 0.3), random.uniform(-0.12, 0.3), random.uniform(-0.25, 0.25)};
}

TEST(DeltaArm, ReachesWhereTheOtherArmOfTheLaboratoryPlays) {
  Random random(1, "delta/reach");
  for (int i = 0; i < 500; ++i) EXPECT_TRUE(DeltaArm().reaches(somewhere(random)));
  EXPECT_FALSE(DeltaArm().reaches({0.0, -1.0, 0.0}));
}

TEST(DeltaArm, ReadingsAndPlaceAreOfOneAnother) {
  Random random(2, "delta/there and back");
  for (int i = 0; i < 200; ++i) {
    const DeltaArm arm = DeltaArm::built({1e-3, 0.01, 0.02}, static_cast<std::uint64_t>(i));
    const Vector3 place = somewhere(random), near = place + Vector3(0.004, -0.003, 0.005);
    EXPECT_LT((arm.place(arm.readings(place), near) - place).norm(), 1e-12);
  }
}

TEST(DeltaArm, ItsJacobianAgreesWithFiniteDifferences) {
  Random random(3, "delta/jacobian");
  for (int i = 0; i < 50; ++i) {
    const DeltaArm arm = DeltaArm::built({1e-3, 0.01, 0.02}, 7);
    const Vector3 place = somewhere(random), psi = arm.readings(place);
    const Matrix3 J = arm.jacobian(place);
    constexpr double kH = 1e-6;
    for (int j = 0; j < 3; ++j) {
      const Vector3 step = kH * Vector3::Unit(j);
      const Vector3 numeric = (arm.place(psi + step, place) - arm.place(psi - step, place)) / (2.0 * kH);
      EXPECT_LT((J.col(j) - numeric).norm(), 1e-8);
    }
  }
}

// What it states is off by what its faults do, and right without them.
TEST(DeltaArm, StatesWhatItsMakersLengthsMakeOfItsReadings) {
  Random random(4, "delta/stated");
  const DeltaArm made, built = DeltaArm::built({3e-4, 0.004, 0.01}, 5);
  double most = 0.0;
  for (int i = 0; i < 100; ++i) {
    const Vector3 place = somewhere(random);
    EXPECT_LT((made.place(made.readings(place), place) - place).norm(), 1e-12);
    most = std::max(most, (made.place(built.readings(place), place) - place).norm());
  }
  EXPECT_GT(most, 1e-3);
  EXPECT_LT(most, 2e-2);
}

}  // namespace
}  // namespace palpate::sim
