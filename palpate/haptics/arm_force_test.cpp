#include "palpate/haptics/arm_force.h"

#include <gtest/gtest.h>

#include "palpate/core/random.h"
#include "palpate/math/random_vector.h"

namespace palpate::haptics {
namespace {

struct TrueArm {
  Vector3 psi, theta;
  device::PhantomLengths nominal, lengths{0.2107, 0.2081};
};

TrueArm any_arm(Random& random) {
  TrueArm arm;
  arm.psi = {random.uniform(-0.7, 0.7), random.uniform(-0.1, 1.4), random.uniform(-0.4, 1.1)};
  device::JointCorrection correction;
  for (int i = 0; i < 3; ++i) {
    correction.gain[i] = random.uniform(0.97, 1.03);
    correction.offset[i] = random.uniform(-0.03, 0.03);
  }
  arm.theta = correction.apply(arm.psi);
  return arm;
}

std::optional<DeviceForce> device_force(const TrueArm& arm) {
  const auto real = device::make_kinematics({.lengths = arm.lengths});
  return DeviceForce::at(arm.psi, *device::make_kinematics({.lengths = arm.nominal}),
                         real->jacobian(arm.theta), *real);
}

Vector3 torques_of(const Vector3& theta, const device::PhantomLengths& lengths, const Vector3& force) {
  return device::phantom_jacobian(theta, lengths).transpose() * force;
}

TEST(ArmForce, TorquesDoTheSameWorkAsTheForceAtTheTip) {
  Random random(1, "arm_force/work");
  for (int i = 0; i < 200; ++i) {
    const TrueArm arm = any_arm(random);
    const Vector3 force = normal3(random, 3.0), turn = normal3(random, 1.0);
    constexpr double kH = 1e-6;  // central difference: rounding 1e-16 / 1e-6, curvature 1e-12
    const Vector3 way = (device::phantom_tip(arm.theta + kH * turn, arm.lengths).m -
                         device::phantom_tip(arm.theta - kH * turn, arm.lengths).m) /
                        (2.0 * kH);
    EXPECT_NEAR(torques_of(arm.theta, arm.lengths, force).dot(turn), force.dot(way), 1e-8);
  }
}

TEST(ArmForce, TheDevicesOwnTorquesPushTheTrueTipWithTheWantedForce) {
  Random random(2, "arm_force/device");
  int possible = 0;
  for (int i = 0; i < 2000; ++i) {
    const TrueArm arm = any_arm(random);
    const auto device = device_force(arm);
    if (!device) continue;
    ++possible;
    const Vector3 wanted = normal3(random, 3.0);
    // What a device does with a Cartesian force, and what the true arm needs for the wanted one.
    const Vector3 by_device = torques_of(arm.psi, arm.nominal, device->M * wanted);
    EXPECT_NEAR((by_device - torques_of(arm.theta, arm.lengths, wanted)).norm(), 0.0, 1e-12);
  }
  EXPECT_GT(possible, 1800);
}

// A Cartesian arm takes a force as its own idea of its place has it: it does the same work there as the wanted one at
// the true tip.
TEST(ArmForce, ACartesianArmDoesTheWorkOfTheWantedForce) {
  Random random(5, "arm_force/cartesian");
  device::ArmModel real;
  real.kind = device::ArmModel::Kind::cartesian;
  real.correction.centre = {0.0, 0.0, 0.17};
  for (double& term : real.correction.terms) term = random.normal(0.004);
  device::ArmModel nominal = real;
  nominal.correction.terms.setZero();
  const auto known = device::make_kinematics(real), own = device::make_kinematics(nominal);
  for (int i = 0; i < 100; ++i) {
    const Vector3 stated = Vector3(0.0, 0.0, 0.17) + normal3(random, 0.04), wanted = normal3(random, 3.0),
                  way = normal3(random, 1.0);
    const auto device = DeviceForce::at(stated, *own, known->jacobian(stated), *known);
    ASSERT_TRUE(device.has_value());
    constexpr double kH = 1e-6;
    const Vector3 true_way =
        (device::arm_tip(real, stated + kH * way).m - device::arm_tip(real, stated - kH * way).m) /
        (2.0 * kH);
    EXPECT_NEAR((device->M * wanted).dot(way), wanted.dot(true_way), 1e-8);
  }
}

TEST(ArmForce, TheGainIsTheLargestInAnyDirection) {
  Random random(3, "arm_force/gain");
  for (int i = 0; i < 20; ++i) {
    const TrueArm arm = any_arm(random);
    const auto device = device_force(arm);
    if (!device) continue;
    double largest = 0.0;
    for (int k = 0; k < 20000; ++k)
      largest = std::max(largest, (device->M * normal3(random, 1.0).normalized()).norm());
    EXPECT_LE(largest, device->gain);
    EXPECT_NEAR(device->gain / largest, 1.0, 1e-3);  // 20,000 directions lie 1 degree apart
  }
}

TEST(ArmForce, AFoldedOrStretchedArmHasNoWay) {
  const double fold = 1.5707;
  const Vector3 folded(0.0, fold, 0.0), bent(0.0, 0.5, 0.3);
  EXPECT_FALSE(device_force({folded, folded, {}, {}}));
  EXPECT_FALSE(device_force({bent, folded, {}, {}}));
  EXPECT_TRUE(device_force({bent, bent, {}, {}}));
}

}  // namespace
}  // namespace palpate::haptics
