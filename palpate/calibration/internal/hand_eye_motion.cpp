#include "palpate/calibration/internal/hand_eye_motion.h"

#include <algorithm>
#include <cmath>

#include "palpate/core/units.h"
#include "palpate/math/linear_algebra.h"

namespace palpate::calibration {
namespace {

// One relative motion, in the marker's and in the camera's axes: A X = X B.
struct Pair {
  Quaternion A, B;
  Vector3 a, b;  // m
};

std::vector<Pair> pairs_of(const std::vector<HandAt>& hand, const std::vector<device::StampedPose>& eye) {
  const std::size_t step = hand.size() / 40 + 1;
  std::vector<Pair> pairs;
  for (std::size_t i = 0; i < hand.size(); i += step)
    for (std::size_t j = i + step; j < hand.size(); j += step) {
      Pair p;
      p.A = hand[i].R.conjugate() * hand[j].R;
      p.B = eye[i].rotation.conjugate() * eye[j].rotation;
      p.a = hand[i].R.conjugate() * (hand[j].t - hand[i].t);
      p.b = eye[i].rotation.conjugate() * (eye[j].translation - eye[i].translation);
      if (p.A.w() < 0) p.A.coeffs() *= -1.0;
      if (p.B.w() < 0) p.B.coeffs() *= -1.0;
      // near half a turn the axis' sign is arbitrary
      if (p.A.w() > 0.15 && p.B.w() > 0.15) pairs.push_back(p);
    }
  return pairs;
}

Vector3 linear_translation(const std::vector<Pair>& pairs, const Quaternion& X) {
  Matrix3 N = Matrix3::Zero();
  Vector3 right = Vector3::Zero();
  for (const auto& p : pairs) {
    const Matrix3 J = p.A.toRotationMatrix() - Matrix3::Identity();
    N += J.transpose() * J;
    right += J.transpose() * (X * p.b - p.a);
  }
  return solve_symmetric(N, right);
}

Quaternion park(const std::vector<Pair>& pairs) {
  Matrix3 M = Matrix3::Zero();
  for (const auto& p : pairs) M += so3_log(p.A) * so3_log(p.B).transpose();
  return Quaternion(nearest_rotation(M).rotation);
}

// hat(a + b) x' = b - a with a, b twice the quaternions' vectors; x' = tan(angle / 2) axis of X. About
// `near`, because half a turn is infinite there.
Quaternion tsai(const std::vector<Pair>& pairs, const Quaternion& near) {
  Matrix3 N = Matrix3::Zero();
  Vector3 right = Vector3::Zero();
  for (const auto& p : pairs) {
    const Vector3 a = 2.0 * p.A.vec(), b = 2.0 * (near * p.B.vec());
    const Matrix3 J = hat(a + b);
    N += J.transpose() * J;
    right += J.transpose() * (b - a);
  }
  const Vector3 x = solve_symmetric(N, right);
  Quaternion X;
  X.vec() = x / std::sqrt(1.0 + x.squaredNorm());
  X.w() = 1.0 / std::sqrt(1.0 + x.squaredNorm());
  return X * near;
}

// Null space of [a - b, hat(a + b), 0, 0; a' - b', hat(a' + b'), a - b, hat(a + b)] over (w, vec) of the two
// quaternions; false where its quadratic has no real root.
bool daniilidis(const std::vector<Pair>& pairs, HandEyeClosedForm& form) {
  Eigen::MatrixXd N = Eigen::MatrixXd::Zero(8, 8);
  const auto dual = [](const Quaternion& q, const Vector3& t) {  // vector part of t q / 2
    return Vector3(0.5 * (q.w() * t + t.cross(q.vec())));
  };
  const double scale = 0.1;  // m: of the size of the moves, so that both halves weigh alike
  for (const auto& p : pairs) {
    const Vector3 a = p.A.vec(), b = p.B.vec(), da = dual(p.A, p.a / scale), db = dual(p.B, p.b / scale);
    Eigen::Matrix<double, 6, 8> J = Eigen::Matrix<double, 6, 8>::Zero();
    J.block<3, 1>(0, 0) = J.block<3, 1>(3, 4) = a - b;
    J.block<3, 3>(0, 1) = J.block<3, 3>(3, 5) = hat(a + b);
    J.block<3, 1>(3, 0) = da - db;
    J.block<3, 3>(3, 1) = hat(da + db);
    N += J.transpose() * J;
  }
  const auto eigen = symmetric_eigen(N);
  const Eigen::Vector4d u1 = eigen.vectors.block(0, 0, 4, 1), v1 = eigen.vectors.block(4, 0, 4, 1);
  const Eigen::Vector4d u2 = eigen.vectors.block(0, 1, 4, 1), v2 = eigen.vectors.block(4, 1, 4, 1);
  // (s u1 + u2).(s v1 + v2) = 0 and |s u1 + u2| l = 1
  const double qa = u1.dot(v1), qb = u1.dot(v2) + u2.dot(v1), qc = u2.dot(v2);
  const double root = qb * qb - 4.0 * qa * qc;
  if (root < 0.0 || std::abs(qa) < 1e-15) return false;
  Eigen::Vector4d q, d;
  double longest = 0.0;
  for (double sign : {-1.0, 1.0}) {
    const double s = (-qb + sign * std::sqrt(root)) / (2.0 * qa);
    const double length2 = (s * u1 + u2).squaredNorm();
    if (length2 <= longest) continue;
    longest = length2;
    q = (s * u1 + u2) / std::sqrt(length2), d = (s * v1 + v2) / std::sqrt(length2);
  }
  form.rotation = Quaternion(q[0], q[1], q[2], q[3]);
  const Vector3 dv = d.tail<3>(), qv = q.tail<3>();  // t = 2 d conj(q)
  form.translation = 2.0 * scale * (-d[0] * qv + q[0] * dv - dv.cross(qv));
  return true;
}

}  // namespace

HandEyeMotion hand_eye_motion(const std::vector<HandAt>& hand) {
  HandEyeMotion motion;
  Eigen::Matrix4d M = Eigen::Matrix4d::Zero();
  for (const auto& h : hand) M += h.R.coeffs() * h.R.coeffs().transpose();
  Quaternion mean;
  mean.coeffs() = symmetric_eigen(M).vectors.col(3);
  Matrix3 scatter = Matrix3::Zero();
  for (const auto& h : hand) {
    const Vector3 w = so3_log(mean.conjugate() * h.R);
    scatter += w * w.transpose();
  }
  const Vector3 values = symmetric_eigenvalues(scatter / static_cast<double>(hand.size()));
  motion.spread = values.cwiseMax(0.0).cwiseSqrt().reverse();
  const std::size_t step = std::max<std::size_t>(1, hand.size() / 200);
  for (std::size_t i = 0; i < hand.size(); i += step)
    for (std::size_t j = 0; j < i; j += step)
      motion.range = std::max(motion.range, angle_between(hand[i].R, hand[j].R));
  std::vector<Quaternion> counted;
  for (const auto& h : hand) {
    if (counted.size() >= 100) break;
    if (std::all_of(counted.begin(), counted.end(),
                    [&](const Quaternion& q) { return angle_between(q, h.R) >= radians_from_degrees(2.0); }))
      counted.push_back(h.R);
  }
  motion.distinct = static_cast<int>(counted.size());
  return motion;
}

std::vector<HandEyeClosedForm> hand_eye_closed_forms(const std::vector<HandAt>& hand,
                                                     const std::vector<device::StampedPose>& eye) {
  std::vector<HandEyeClosedForm> forms;
  const auto pairs = pairs_of(hand, eye);
  if (pairs.size() < 3) return forms;
  const Quaternion by_park = park(pairs), by_tsai = tsai(pairs, by_park);
  forms.push_back({"Park", by_park, linear_translation(pairs, by_park)});
  forms.push_back({"Tsai", by_tsai, linear_translation(pairs, by_tsai)});
  HandEyeClosedForm form{"Daniilidis", {}, {}};
  if (daniilidis(pairs, form)) forms.push_back(form);
  return forms;
}

}  // namespace palpate::calibration
