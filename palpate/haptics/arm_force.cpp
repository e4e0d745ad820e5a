#include "palpate/haptics/arm_force.h"

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>

namespace palpate::haptics {
namespace {

bool has_force_everywhere(const device::TipJacobian& J, const device::ArmKinematics& arm) {
  return device::manipulability(J) > arm.least_manipulability();
}

Matrix3 to_device(const device::TipJacobian& own, const device::TipJacobian& real) {
  if (own.cols() == 3) {
    const Matrix3 own_transposed = own.transpose(), real_transposed = real.transpose();
    return own_transposed.inverse() * real_transposed;
  }
  const Matrix3 squares = own * own.transpose(), mixed = own * real.transpose();
  return squares.inverse() * mixed;
}

}  // namespace

std::optional<DeviceForce> DeviceForce::at(const device::JointVector& psi,
                                           const device::ArmKinematics& nominal,
                                           const device::TipJacobian& real,
                                           const device::ArmKinematics& calibrated) {
  const device::TipJacobian own = nominal.jacobian(psi);
  if (!has_force_everywhere(own, nominal) || !has_force_everywhere(real, calibrated)) return std::nullopt;
  DeviceForce force;
  force.M = to_device(own, real);
  Eigen::SelfAdjointEigenSolver<Matrix3> squares;
  squares.computeDirect(force.M.transpose() * force.M, Eigen::EigenvaluesOnly);
  // The direct formula loses half of the digits where eigenvalues meet, as they do here.
  force.gain = std::sqrt(squares.eigenvalues().maxCoeff()) * (1.0 + 1e-6);
  constexpr double kMostGain = 2.0;
  if (!(force.gain < kMostGain)) return std::nullopt;
  return force;
}

std::optional<DeviceForce> DeviceForce::through_motors(const device::TipJacobian& real,
                                                       const device::ArmKinematics& calibrated,
                                                       const device::JointVector& limits) {
  if (!has_force_everywhere(real, calibrated)) return std::nullopt;
  DeviceForce force;
  force.J = real;
  for (Eigen::Index j = 0; j < force.J.cols(); ++j)  // |tau_j| <= |J_j| |f|
    force.most_n = std::min(force.most_n, limits[j] / force.J.col(j).norm());
  return force;
}

device::JointVector DeviceForce::torques(const Vector3& force, const device::JointVector& limits) const {
  device::JointVector torques = J.transpose() * force;
  double most = 1.0;
  for (Eigen::Index j = 0; j < torques.size(); ++j) most = std::max(most, std::abs(torques[j]) / limits[j]);
  if (most > 1.0) torques /= most;
  return torques;
}

}  // namespace palpate::haptics
