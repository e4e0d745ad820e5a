#include "palpate/calibration/internal/hand_eye_start.h"

#include <algorithm>
#include <cmath>

#include "palpate/calibration/noise/robust_scale.h"
#include "palpate/core/statistics.h"
#include "palpate/math/linear_algebra.h"

namespace palpate::calibration {
namespace {

// Rotation of X over relative rotations of distant pairs, weighted down where a pair does not agree.
Quaternion start_rotation(const std::vector<HandAt>& hand, const std::vector<device::StampedPose>& eye) {
  std::vector<Vector3> a, b;
  const std::size_t n = eye.size();
  std::vector<std::size_t> strides;
  if (n <= 30) {  // few poses: all pairs
    for (std::size_t stride = 1; stride < n; ++stride) strides.push_back(stride);
  } else {
    for (std::size_t divisor : {2, 3, 5, 8, 13}) strides.push_back(n / divisor);
  }
  for (std::size_t stride : strides) {
    for (std::size_t i = 0; i + stride < n; ++i) {
      const Vector3 h = so3_log(hand[i].R.conjugate() * hand[i + stride].R);
      const Vector3 e = so3_log(eye[i].rotation.conjugate() * eye[i + stride].rotation);
      // near half a turn the axis' sign is arbitrary; tiny turns say nothing
      if (std::max(h.norm(), e.norm()) > 2.8 || h.norm() < 0.02) continue;
      a.push_back(h), b.push_back(e);
    }
  }
  Quaternion R = Quaternion::Identity();
  std::vector<double> weight;
  std::vector<double> misfit;
  for (std::size_t i = 0; i < a.size(); ++i) misfit.push_back(std::abs(a[i].norm() - b[i].norm()));
  for (int round = 0; round < 15; ++round) {
    const double scale = std::max(2.0 * median(misfit), 1e-9);
    Matrix3 M = Matrix3::Zero();
    for (std::size_t i = 0; i < a.size(); ++i)
      M += a[i] * b[i].transpose() / (1.0 + std::pow(misfit[i] / scale, 2));
    R = Quaternion(nearest_rotation(M).rotation);
    for (std::size_t i = 0; i < a.size(); ++i) misfit[i] = (a[i] - R * b[i]).norm();
  }
  return R;
}

// Z's rotation as a weighted mean of quaternions (Markley 2007), then both translations linearly; blunders
// weighted down.
HandEyeState start_state(const std::vector<HandAt>& hand, const std::vector<device::StampedPose>& eye,
                         const Quaternion& Rx, double delay) {
  HandEyeState x;
  x.Rx = Rx, x.delay = delay;
  std::vector<double> misfit(eye.size(), 0.0);
  for (int round = 0; round < 10; ++round) {
    const double scale = std::max(2.0 * median(misfit), 1e-9);
    Eigen::Matrix4d M = Eigen::Matrix4d::Zero();
    for (std::size_t i = 0; i < eye.size(); ++i) {
      const Eigen::Vector4d q = (hand[i].R * Rx * eye[i].rotation.conjugate()).coeffs();
      M += q * q.transpose() / (1.0 + std::pow(misfit[i] / scale, 2));
    }
    x.Rz.coeffs() = symmetric_eigen(M).vectors.col(3);
    for (std::size_t i = 0; i < eye.size(); ++i)
      misfit[i] = angle_between(hand[i].R * Rx, x.Rz * eye[i].rotation);
  }
  std::fill(misfit.begin(), misfit.end(), 0.0);
  for (int round = 0; round < 15; ++round) {
    const double scale = std::max(2.0 * median(misfit), 1e-9);
    Matrix6 A = Matrix6::Zero();
    Vector6 b = Vector6::Zero();
    for (std::size_t i = 0; i < eye.size(); ++i) {
      Eigen::Matrix<double, 3, 6> J;
      J << hand[i].R.toRotationMatrix(), -Matrix3::Identity();
      const Vector3 d = x.Rz * eye[i].translation - hand[i].t;
      const double w = cauchy_weight(std::pow(misfit[i] / scale, 2), 1.0);
      A += w * J.transpose() * J, b += w * J.transpose() * d;
    }
    const Vector6 t = solve_symmetric(A, b);
    x.tx = t.head<3>(), x.tz = t.tail<3>();
    for (std::size_t i = 0; i < eye.size(); ++i)
      misfit[i] = (hand[i].R * x.tx + hand[i].t - x.Rz * eye[i].translation - x.tz).norm();
  }
  return x;
}

}  // namespace

HandEyeStart hand_eye_start(const std::vector<device::StampedPose>& hand,
                            const std::vector<device::StampedPose>& eye, double delay, double gap,
                            bool free_delay) {
  std::vector<device::StampedPose> some, kept;
  const std::size_t step = std::max<std::size_t>(1, eye.size() / 300);  // 300 poses find the basin
  for (std::size_t i = 0; i < eye.size(); i += step) some.push_back(eye[i]);
  const auto at = enclosed(hand, some, delay, gap, kept);
  HandEyeStart start;
  if (kept.size() < 4) return start;
  start.state = start_state(at, kept, start_rotation(at, kept), delay);
  HandEyeProblem problem{hand, kept, gap, free_delay};
  problem.whiten = hand_eye_whitening(problem.residuals(start.state), nullptr);
  problem.solve(start.state, 25);
  std::vector<double> turn, shift;
  for (const auto& r : problem.residuals(start.state))
    turn.push_back(r.head<3>().norm()), shift.push_back(r.tail<3>().norm());
  if (turn.size() >= 4) start.quality = std::log(median(turn) + 1e-12) + std::log(median(shift) + 1e-12);
  return start;
}

}  // namespace palpate::calibration
