// Forces at the tip as joint torques, and what has to be requested of a device that computes torques itself.
//
// Virtual work: tau . d theta = f . dx with dx = J d theta gives tau = J(theta)^T f, with the Jacobian of the
// CALIBRATED arm. A device that takes a Cartesian force applies Jn(psi)^T f_device with its nominal lengths
// at its own uncorrected angles; the force to ask for is therefore
//   f_device = M f,   M = Jn(psi)^-T J(theta)^T
// and then the hand feels f (Cavusoglu, Feygin, Tendick 2002 for J; palpate/device/phantom.h). The gains of
// the joint correction are taken as errors of the encoders, not of the transmissions: motors' torques are
// right. ArmBase, N, N m, rad. Pure functions, any thread, no allocation.
#pragma once

#include <optional>

#include "palpate/device/phantom.h"

namespace palpate::haptics {

inline Vector3 joint_torques(const Vector3& theta, const device::PhantomLengths& lengths,
                             const Vector3& force) {
  return device::phantom_jacobian(theta, lengths).transpose() * force;
}

struct DeviceForce {
  Matrix3 M = Matrix3::Identity();
  double gain = 1.0;  // largest |M f| / |f|

  // None where the arm is folded or stretched so far that it has no force in some direction, or where the
  // device's own geometry differs so much from the true one that a force would grow to more than twice.
  static std::optional<DeviceForce> at(const Vector3& psi, const device::PhantomLengths& nominal,
                                       const Vector3& theta, const device::PhantomLengths& lengths);
};

}  // namespace palpate::haptics
