#include "palpate/math/pose.h"

#include <gtest/gtest.h>

#include "palpate/core/random.h"
#include "palpate/core/units.h"
#include "palpate/math/random_vector.h"

namespace palpate::inline math {
namespace {

// What must not compile: chains whose inner frames differ, points of another frame, points used as
// directions.
static_assert(Composable<Pose<World, ArmBase>, Pose<ArmBase, Tip>>);
static_assert(!Composable<Pose<World, ArmBase>, Pose<CameraMarker, Tip>>);
static_assert(!Composable<Pose<World, Tip>, Point<World>>);
static_assert(Composable<Pose<World, Tip>, Point<Tip>>);
static_assert(!std::is_convertible_v<Pose<World, Tip>, Pose<Tip, World>>);
static_assert(!std::is_convertible_v<Point<World>, Direction<World>>);
static_assert(std::is_same_v<decltype(Pose<World, ArmBase>{} * Pose<ArmBase, Tip>{}), Pose<World, Tip>>);

Pose<World, Tip> random_pose(Random& random) {
  return {so3_exp(Vector3(random.normal(), random.normal(), random.normal())),
          Vector3(random.normal(), random.normal(), random.normal())};
}

TEST(Pose, InverseUndoesThePose) {
  Random random(1);
  for (int i = 0; i < 100; ++i) {
    const auto X = random_pose(random);
    const Point<Tip> p{Vector3(random.normal(), random.normal(), random.normal())};
    EXPECT_NEAR(((X.inverse() * (X * p)).m - p.m).norm(), 0.0, 1e-13);  // a few roundings of values near 1
  }
}

TEST(Pose, AgreesWithHomogeneousMatrices) {
  Random random(2);
  const auto a = random_pose(random);
  const Pose<Tip, TipMarker> b{so3_exp(Vector3(0.3, -0.2, 0.1)), Vector3(1, 2, 3)};
  const auto matrix = [](const auto& X) {
    Eigen::Matrix4d m = Eigen::Matrix4d::Identity();
    m.topLeftCorner<3, 3>() = X.matrix();
    m.topRightCorner<3, 1>() = X.translation;
    return m;
  };
  EXPECT_NEAR((matrix(a * b) - matrix(a) * matrix(b)).norm(), 0.0, 1e-14);
}

TEST(So3, LogarithmUndoesTheExponentialUpToHalfATurn) {
  Random random(3);
  for (double angle : {0.0, 1e-12, 1e-7, 1e-3, 1.0, 3.0, 3.141592}) {
    const Vector3 axis = Vector3(random.normal(), random.normal(), random.normal()).normalized();
    EXPECT_NEAR((so3_log(so3_exp(angle * axis)) - angle * axis).norm(), 0.0, 1e-9) << angle;
  }
}

TEST(So3, InverseLeftJacobianAgreesWithFiniteDifferences) {
  Random random(4);
  for (double angle : {0.0, 1e-6, 0.005, 0.02, 0.5, 2.0, 3.0}) {
    const Vector3 r = angle * Vector3(random.normal(), random.normal(), random.normal()).normalized();
    Matrix3 numeric;
    for (int i = 0; i < 3; ++i) {
      const Vector3 h = 1e-6 * Vector3::Unit(i);
      numeric.col(i) = (so3_log(so3_exp(h) * so3_exp(r)) - so3_log(so3_exp(-h) * so3_exp(r))) / 2e-6;
    }
    // central differences err by h^2 times the third derivative, which grows towards half a turn
    EXPECT_NEAR((so3_left_jacobian_inverse(r) - numeric).norm(), 0.0, 1e-8) << angle;
  }
}

TEST(So3, RotationBetweenIsTheShortestTurnAlsoWhereDirectionsAreOpposite) {
  Random random(3, "so3");
  for (int i = 0; i < 200; ++i) {
    const Vector3 a = normal3(random), b = i % 10 == 0 ? Vector3(-2.0 * a) : normal3(random);
    const Quaternion q = rotation_between(a, b);
    EXPECT_NEAR((q * a.normalized() - b.normalized()).norm(), 0.0, 1e-14);
    EXPECT_NEAR(angle_between(q, Quaternion::Identity()), std::atan2(a.cross(b).norm(), a.dot(b)), 1e-12);
  }
}

TEST(So3, FixedAxisAnglesAreAppliedInTheOrderXYZ) {
  const Quaternion q = rotation_from_xyz(Vector3(radians_from_degrees(90), 0, radians_from_degrees(90)));
  // y -> z by the turn about x; z stays under the turn about z
  EXPECT_NEAR((q * Vector3::UnitY() - Vector3::UnitZ()).norm(), 0.0, 1e-15);
}

}  // namespace
}  // namespace palpate::inline math
