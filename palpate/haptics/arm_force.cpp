#include "palpate/haptics/arm_force.h"

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <cmath>

namespace palpate::haptics {

std::optional<DeviceForce> DeviceForce::at(const Vector3& psi, const device::PhantomLengths& nominal,
                                           const Vector3& theta, const device::PhantomLengths& lengths) {
  const Matrix3 own = device::phantom_jacobian(psi, nominal).transpose();
  const Matrix3 real = device::phantom_jacobian(theta, lengths).transpose();
  constexpr double kLeastDeterminant = 1e-4;  // m^3; 0.013 in the middle of a Premium's range
  if (!(std::abs(own.determinant()) > kLeastDeterminant) ||
      !(std::abs(real.determinant()) > kLeastDeterminant))
    return std::nullopt;
  DeviceForce force;
  force.M = own.inverse() * real;
  Eigen::SelfAdjointEigenSolver<Matrix3> squares;
  squares.computeDirect(force.M.transpose() * force.M, Eigen::EigenvaluesOnly);
  // The direct formula loses half of the digits where eigenvalues meet, as they do here.
  force.gain = std::sqrt(squares.eigenvalues().maxCoeff()) * (1.0 + 1e-6);
  constexpr double kMostGain = 2.0;
  if (!(force.gain < kMostGain)) return std::nullopt;
  return force;
}

}  // namespace palpate::haptics
