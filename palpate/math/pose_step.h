// Small steps of a pose in an optimisation, and what is known of a pose beforehand.
//
// A step is (rotation vector in rad, translation in m), both in the axes of the outer frame A of Pose<A, B>:
// the rotation is put before the pose's own, the translation is added. Pure functions, no thread rule.
// Source: Sola, Deray, Atchuthan (2018), "A micro Lie theory for state estimation in robotics", section II.
#pragma once

#include "palpate/math/levenberg_marquardt.h"
#include "palpate/math/pose.h"

namespace palpate::inline math {

template <typename A, typename B>
Pose<A, B> moved(const Pose<A, B>& X, const Vector6& step) {
  return {(so3_exp(step.head<3>()) * X.rotation).normalized(), X.translation + step.tail<3>()};
}

// The step that leads from `from` to X.
template <typename A, typename B>
Vector6 deviation(const Pose<A, B>& X, const Pose<A, B>& from) {
  Vector6 e;
  e << so3_log(X.rotation * from.rotation.conjugate()), X.translation - from.translation;
  return e;
}

// A pose that was measured: e^T information e of its deviation e, as a part of the cost.
template <typename A, typename B>
struct PosePrior {
  Pose<A, B> mean;
  Matrix6 information = Matrix6::Zero();

  PosePrior() = default;
  PosePrior(const Pose<A, B>& measured, Matrix6 covariance) : mean(measured) {
    covariance.diagonal().array() += 1e-18;  // one said to be perfect stays invertible
    information = inverse_symmetric(covariance);
  }

  double cost(const Pose<A, B>& X) const {
    const Vector6 e = deviation(X, mean);
    return e.dot(information * e);
  }
  // Adds its part to the equations of the pose's six unknowns. Returns the cost.
  template <typename JtJ, typename Jtr>
  double add(const Pose<A, B>& X, JtJ&& A_block, Jtr&& b_block) const {
    const Vector6 e = deviation(X, mean);
    const Matrix3 J = so3_left_jacobian_inverse(e.head<3>());  // of the rotation; the translation's is 1
    Matrix6 A_prior = information;
    A_prior.topRows<3>() = J.transpose() * information.topRows<3>();
    A_prior.leftCols<3>() = A_prior.leftCols<3>() * J;
    Vector6 b = information * e;
    const double cost = e.dot(b);
    b.head<3>() = J.transpose() * b.head<3>();
    A_block += A_prior;
    b_block += b;
    return cost;
  }
};

}  // namespace palpate::inline math
