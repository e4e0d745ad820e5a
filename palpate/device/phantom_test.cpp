#include "palpate/device/phantom.h"

#include <gtest/gtest.h>

#include "palpate/core/random.h"
#include "palpate/core/units.h"

namespace palpate::device {
namespace {

Vector3 random_theta(Random& random) {
  return {random.uniform(-0.8, 0.8), random.uniform(-0.17, 1.48), random.uniform(-0.43, 1.13)};
}

TEST(Phantom, TheTipIsAtTheOriginAtReset) { EXPECT_NEAR(phantom_tip(Vector3::Zero()).m.norm(), 0.0, 1e-16); }

TEST(Phantom, JacobianAgreesWithFiniteDifferences) {
  Random random(1);
  const PhantomLengths lengths{0.2, 0.17};
  for (int n = 0; n < 50; ++n) {
    const Vector3 theta = random_theta(random);
    const Matrix3 J = phantom_jacobian(theta, lengths);
    for (int j = 0; j < 3; ++j) {
      const double h = 1e-6;
      const Vector3 step = h * Vector3::Unit(j);
      const Vector3 numeric =
          (phantom_tip(theta + step, lengths).m - phantom_tip(theta - step, lengths).m) / (2 * h);
      EXPECT_NEAR((J.col(j) - numeric).norm(), 0.0, 1e-9);  // central difference: h^2 and 1e-16 / h
    }
  }
}

TEST(Phantom, InverseFindsTheJointAnglesOverTheWholeRange) {
  Random random(2);
  const PhantomLengths lengths{0.2, 0.17};
  for (int n = 0; n < 2000; ++n) {
    const Vector3 theta = random_theta(random);
    Vector3 found;
    ASSERT_TRUE(phantom_inverse(phantom_tip(theta, lengths), lengths, found));
    EXPECT_NEAR((phantom_tip(found, lengths).m - phantom_tip(theta, lengths).m).norm(), 0.0, 1e-12);
    // beyond a straight arm (t2 - t3 > 90 deg) the elbow bends the other way: the same place, other angles
    if (theta[1] - theta[2] < 1.5) {
      EXPECT_NEAR((found - theta).norm(), 0.0, 1e-6);
    }
  }
  Vector3 unused;
  EXPECT_FALSE(phantom_inverse({Vector3(0, 0, 1)}, lengths, unused));
}

TEST(Phantom, GimbalAnglesGiveBackTheStylus) {
  Random random(3);
  for (int n = 0; n < 200; ++n) {
    const Vector3 theta = random_theta(random);
    const Quaternion wanted = so3_exp(Vector3(random.normal(), random.normal(), random.normal()));
    EXPECT_NEAR(angle_between(phantom_stylus(theta, phantom_gimbal(theta, wanted)), wanted), 0.0, 1e-7);
  }
}

}  // namespace
}  // namespace palpate::device
