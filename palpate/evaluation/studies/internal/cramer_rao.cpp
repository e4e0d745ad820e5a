#include "palpate/evaluation/studies/internal/cramer_rao.h"

#include <Eigen/LU>
#include <cmath>
#include <limits>

#include "palpate/math/linear_algebra.h"

namespace palpate::evaluation::studies {

Eigen::Matrix<double, 3, kBoundSize> tip_derivatives(const TrueArm& arm, const Vector3& psi,
                                                     const Quaternion& R_world_marker) {
  const Vector3 theta = arm.joints.apply(psi);
  const Matrix3 R = arm.X_world_base.matrix();
  const Matrix3 by_joint = R * device::phantom_jacobian(theta, arm.lengths);
  Eigen::Matrix<double, 3, kBoundSize> J;
  J.leftCols<3>() = -hat(R * device::phantom_tip(theta, arm.lengths).m);
  J.middleCols<3>(3) = Matrix3::Identity();
  J.middleCols<3>(kBoundGains) = by_joint * psi.asDiagonal();
  J.middleCols<2>(kBoundOffsets) = by_joint.rightCols<2>();
  J.middleCols<3>(kBoundTip) = -R_world_marker.toRotationMatrix();
  return J;
}

Eigen::MatrixXd parameter_bound(const TrueArm& arm, const std::vector<BoundSample>& samples, TipIs tip) {
  const Eigen::Index size = tip == TipIs::estimated ? kBoundSize : kBoundTip;
  Eigen::MatrixXd information = Eigen::MatrixXd::Zero(size, size);
  for (const auto& sample : samples) {
    const auto J = tip_derivatives(arm, sample.psi, sample.R_world_marker);
    const Eigen::Matrix<double, kBoundSize, kBoundSize> told =
        J.transpose() * sample.covariance.inverse() * J;
    information += told.topLeftCorner(size, size);
  }
  // scaled by its diagonal before inverting: turns and places differ by orders of magnitude
  const Eigen::VectorXd d = information.diagonal().cwiseSqrt().cwiseInverse();
  const Eigen::MatrixXd scaled = d.asDiagonal() * information * d.asDiagonal();
  constexpr double kSingular = 1e-12;
  if (!scaled.allFinite() || symmetric_eigenvalues(scaled)[0] < kSingular)
    return Eigen::MatrixXd::Constant(size, size, std::numeric_limits<double>::infinity());
  return covariance_from_information(information);
}

double workspace_bound(const TrueArm& arm, const Eigen::MatrixXd& parameter_covariance,
                       const std::vector<Vector3>& psi) {
  const Eigen::MatrixXd C = parameter_covariance.topLeftCorner(kBoundTip, kBoundTip);
  double sum = 0.0;
  for (const auto& reading : psi) {
    const Eigen::MatrixXd J = tip_derivatives(arm, reading, Quaternion::Identity()).leftCols(kBoundTip);
    sum += (J * C * J.transpose()).trace();
  }
  return std::sqrt(sum / static_cast<double>(psi.size()));
}

}  // namespace palpate::evaluation::studies
