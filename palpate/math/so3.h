// Rotations: exponential, logarithm and small helpers, exact also near zero and near half a turn.
// Source: Sola, Deray, Atchuthan, "A micro Lie theory for state estimation in robotics" (2018), equations
// 132-146.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cmath>

namespace palpate::inline math {

using Vector3 = Eigen::Vector3d;
using Matrix3 = Eigen::Matrix3d;
using Vector6 = Eigen::Matrix<double, 6, 1>;
using Matrix6 = Eigen::Matrix<double, 6, 6>;
using Quaternion = Eigen::Quaterniond;

// Cross-product matrix: hat(a) b = a x b.
inline Matrix3 hat(const Vector3& a) {
  Matrix3 m;
  m << 0, -a.z(), a.y(), a.z(), 0, -a.x(), -a.y(), a.x(), 0;
  return m;
}

// Rotation by |w| radians about w.
inline Quaternion so3_exp(const Vector3& w) {
  const double angle2 = w.squaredNorm();
  const double angle = std::sqrt(angle2);
  // sin(a/2)/a, by its series where the division would lose digits
  const double k = angle < 1e-6 ? 0.5 - angle2 / 48.0 : std::sin(0.5 * angle) / angle;
  return Quaternion(std::cos(0.5 * angle), k * w.x(), k * w.y(), k * w.z());
}

// Inverse of so3_exp, |result| <= pi.
inline Vector3 so3_log(const Quaternion& q) {
  const double sign = q.w() < 0 ? -1.0 : 1.0;
  const double n = q.vec().norm();
  const double w = sign * q.w();
  const double k = n < 1e-9 ? 2.0 / w : 2.0 * std::atan2(n, w) / n;
  return sign * k * q.vec();
}

// Inverse of the left Jacobian: log(exp(e) exp(r)) = r + this * e for small e. Equation 146; |r| < pi.
inline Matrix3 so3_left_jacobian_inverse(const Vector3& r) {
  const double angle2 = r.squaredNorm(), angle = std::sqrt(angle2);
  // by its series where the difference of two large numbers would lose digits
  const double k = angle < 1e-2 ? 1.0 / 12.0 + angle2 / 720.0
                                : 1.0 / angle2 - (1.0 + std::cos(angle)) / (2.0 * angle * std::sin(angle));
  return Matrix3::Identity() - 0.5 * hat(r) + k * hat(r) * hat(r);
}

// Angle between two rotations, radians in [0, pi].
inline double angle_between(const Quaternion& a, const Quaternion& b) {
  return so3_log(a.conjugate() * b).norm();
}

// The shortest turn of direction a onto direction b (any lengths but zero); half a turn about an axis square
// to a where they are opposite.
inline Quaternion rotation_between(const Vector3& a, const Vector3& b) {
  const Vector3 u = a.normalized(), v = b.normalized(), middle = u + v;
  if (middle.squaredNorm() < 1e-30) {
    const Vector3 axis = u.unitOrthogonal();
    return Quaternion(0.0, axis.x(), axis.y(), axis.z());
  }
  const Vector3 half = middle.normalized(), axis = u.cross(half);
  return Quaternion(u.dot(half), axis.x(), axis.y(), axis.z()).normalized();
}

// Rotation from angles in radians about the fixed axes x, then y, then z (R = Rz Ry Rx).
inline Quaternion rotation_from_xyz(const Vector3& angles) {
  return Quaternion(Eigen::AngleAxisd(angles.z(), Vector3::UnitZ()) *
                    Eigen::AngleAxisd(angles.y(), Vector3::UnitY()) *
                    Eigen::AngleAxisd(angles.x(), Vector3::UnitX()));
}

}  // namespace palpate::inline math
