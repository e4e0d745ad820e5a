// Forces at the tip as joint torques, and what has to be requested of a device that computes torques itself.
//
// Virtual work: tau . d theta = f . dx with dx = J d theta gives tau = J(theta)^T f, with the Jacobian of the
// CALIBRATED arm (Khatib 1987, "A unified approach for motion and force control of robot manipulators"). An
// arm whose motors take torques is commanded with these. A device that takes a Cartesian force applies
// Jn(psi)^T f_device with its nominal kinematics at its own uncorrected angles; the force to ask for is
//   f_device = M f,   M = (Jn(psi)^T)^+ J(theta)^T
// With three joints the pseudo-inverse is Jn^-T, and the hand feels f. With more it is (Jn Jn^T)^-1 Jn: of all
// forces that such a device can be asked for, M f gives the torques nearest to J^T f; what is left moves the
// joints against each other and has no part in the tip's motion but for the difference between the two
// kinematics. The gains of the joint correction are taken as errors of the encoders, not of the transmissions:
// motors' torques are right. ArmBase, N, N m, rad. Pure functions, any thread, no allocation.
#pragma once

#include <limits>
#include <optional>

#include "palpate/device/arm_kinematics.h"

namespace palpate::haptics {

struct DeviceForce {
  Matrix3 M = Matrix3::Identity();
  double gain = 1.0;  // largest |M f| / |f|
  // Of an arm that takes torques: its calibrated Jacobian, and the force that its motors have in every
  // direction.
  device::TipJacobian J = device::TipJacobian::Zero(3, 0);
  double most_n = std::numeric_limits<double>::infinity();

  // `real` is the calibrated arm's Jacobian at theta. None where the arm is folded or stretched so far that it
  // has no force in some direction, or where the device's own geometry differs so much from the true one that
  // a force would grow to more than twice.
  static std::optional<DeviceForce> at(const device::JointVector& psi, const device::ArmKinematics& nominal,
                                       const device::TipJacobian& real,
                                       const device::ArmKinematics& calibrated);
  // The same of an arm that takes torques, of at most these, N m.
  static std::optional<DeviceForce> through_motors(const device::TipJacobian& real,
                                                   const device::ArmKinematics& calibrated,
                                                   const device::JointVector& limits);

  // N m. Where a force needs more of a motor than it may give, all are lowered alike: its direction stays.
  device::JointVector torques(const Vector3& force, const device::JointVector& limits) const;
};

}  // namespace palpate::haptics
