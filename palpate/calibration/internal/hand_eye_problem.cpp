#include "palpate/calibration/internal/hand_eye_problem.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "palpate/calibration/noise/robust_scale.h"
#include "palpate/core/statistics.h"
#include "palpate/math/linear_algebra.h"

namespace palpate::calibration {
namespace {

constexpr double kMedianChi2With6 = 5.348;
constexpr std::size_t kFewResiduals = 60;  // a 6x6 scatter has 21 numbers
constexpr double kMedianNorm3 = 1.538;     // median length of a normal 3-vector with unit deviations

}  // namespace

void sort_by_time(std::vector<device::StampedPose>& poses) {
  std::stable_sort(poses.begin(), poses.end(),
                   [](const auto& a, const auto& b) { return a.time_s < b.time_s; });
  poses.erase(std::unique(poses.begin(), poses.end(),
                          [](const auto& a, const auto& b) { return a.time_s == b.time_s; }),
              poses.end());
}

std::size_t drop_stray_times(std::vector<device::StampedPose>& poses) {
  constexpr double kFar = 100.0;       // times the recording's middle half
  constexpr std::size_t kOneIn = 100;  // more than that is no stray stamp
  const std::size_t n = poses.size();
  if (n < 4) return 0;
  const double middle = poses[n / 2].time_s, half = poses[3 * n / 4].time_s - poses[n / 4].time_s;
  const auto stray = [&](const device::StampedPose& p) { return std::abs(p.time_s - middle) > kFar * half; };
  const auto count = static_cast<std::size_t>(std::count_if(poses.begin(), poses.end(), stray));
  if (count > std::max<std::size_t>(1, n / kOneIn)) return 0;
  return std::erase_if(poses, stray);
}

constexpr double kSameTime = 1e-6;  // s, as times are written
constexpr double kRounding = 1e-6;  // of a gap: poses at the slowest rate that is allowed are near enough

bool hand_at(const std::vector<device::StampedPose>& hand, double time_s, double max_gap_s, HandAt& out) {
  const auto next = std::lower_bound(hand.begin(), hand.end(), time_s,
                                     [](const auto& p, double s) { return p.time_s < s; });
  if (next == hand.end()) return false;
  if (next == hand.begin() && next->time_s > time_s) return false;
  const auto& b = next == hand.begin() ? *(next + 1) : *next;
  const auto& a = next == hand.begin() ? *next : *(next - 1);
  const double gap = b.time_s - a.time_s, s = (time_s - a.time_s) / gap;
  if (gap > (1.0 + kRounding) * max_gap_s) {
    // Poses of a marker at rest are far apart. Where the hand was seen just then nothing is interpolated.
    const auto* same = time_s - a.time_s <= kSameTime ? &a : b.time_s - time_s <= kSameTime ? &b : nullptr;
    if (same != nullptr) out = {same->rotation, same->translation, Vector3::Zero(), Vector3::Zero()};
    return same != nullptr;
  }
  const Vector3 turn = so3_log(a.rotation.conjugate() * b.rotation);
  out.R = a.rotation * so3_exp(s * turn);
  out.t = (1 - s) * a.translation + s * b.translation;
  out.w = out.R * turn / gap;
  out.v = (b.translation - a.translation) / gap;
  return true;
}

std::vector<HandAt> enclosed(const std::vector<device::StampedPose>& hand,
                             const std::vector<device::StampedPose>& eye, double delay, double max_gap_s,
                             std::vector<device::StampedPose>& kept) {
  std::vector<HandAt> at;
  kept.clear();
  for (const auto& e : eye) {
    HandAt h;
    if (!hand_at(hand, e.time_s + delay, max_gap_s, h)) continue;
    at.push_back(h);
    kept.push_back(e);
  }
  return at;
}

HandEyeState HandEyeState::moved(const HandEyeUnknowns& d) const {
  return {(so3_exp(d.segment<3>(0)) * Rx).normalized(), (so3_exp(d.segment<3>(6)) * Rz).normalized(),
          tx + d.segment<3>(3), tz + d.segment<3>(9), delay + d(12)};
}

Vector6 hand_eye_residual(const HandEyeState& x, const HandAt& hand, const device::StampedPose& eye,
                          HandEyeJacobian* J) {
  const Quaternion Rp = hand.R * x.Rx, Rq = x.Rz * eye.rotation;
  const Vector3 arm_x = hand.R * x.tx, arm_z = x.Rz * eye.translation;
  const Vector3 d = arm_z + x.tz - arm_x - hand.t;
  const Matrix3 to_camera = Rp.conjugate().toRotationMatrix();
  Vector6 r;
  r.head<3>() = so3_log(Rp.conjugate() * Rq);
  r.tail<3>() = to_camera * d;
  if (J != nullptr) {
    const Matrix3 Rh = hand.R.toRotationMatrix(), turn = so3_left_jacobian_inverse(r.head<3>()) * to_camera;
    const Matrix3 shift = to_camera * hat(d);  // the camera axes, in which d is told, turn with hand and X
    J->block<3, 3>(0, 0) = -turn * Rh;
    J->block<3, 3>(3, 0) = shift * Rh;
    J->block<3, 3>(0, 3).setZero();
    J->block<3, 3>(3, 3) = -to_camera * Rh;
    J->block<3, 3>(0, 6) = turn;
    J->block<3, 3>(3, 6) = -to_camera * hat(arm_z);
    J->block<3, 3>(0, 9).setZero();
    J->block<3, 3>(3, 9) = to_camera;
    J->block<3, 1>(0, 12) = -turn * hand.w;
    J->block<3, 1>(3, 12) = shift * hand.w - to_camera * (hand.v + hand.w.cross(arm_x));
  }
  return r;
}

std::vector<Vector6> HandEyeProblem::residuals(const HandEyeState& x) const {
  std::vector<Vector6> result;
  each(x,
       [&](std::size_t i, const HandAt& at) { result.push_back(hand_eye_residual(x, at, eye[i], nullptr)); });
  return result;
}

double HandEyeProblem::evaluate(const HandEyeState& x, HandEyeEquations* equations) const {
  double sum = 0.0;
  int n = 0;
  HandEyeJacobian J;
  each(x, [&](std::size_t i, const HandAt& at) {
    const Vector6 r = whiten * hand_eye_residual(x, at, eye[i], equations ? &J : nullptr);
    const Robust robust = cauchy(r.squaredNorm(), kHandEyeCauchy);
    sum += robust.loss;
    ++n;
    if (!equations) return;
    if (!free_delay) J.col(12).setZero();
    equations->add(whiten * J, r, robust.weight);
  });
  if (n == 0) return std::numeric_limits<double>::infinity();
  if (equations) equations->JtJ /= n, equations->Jtr /= n;
  return sum / n;
}

LeastSquaresResult HandEyeProblem::solve(HandEyeState& x, int most_iterations) const {
  return minimise<kHandEyeUnknowns>(
      x, [&](const HandEyeState& at, HandEyeEquations* equations) { return evaluate(at, equations); },
      [](const HandEyeState& at, const HandEyeUnknowns& step) { return at.moved(step); },
      {.most_iterations = most_iterations});
}

// Inverse square root of the residuals' robust scatter, scaled so that the middle residual counts as honest.
Matrix6 hand_eye_whitening(const std::vector<Vector6>& residuals, const Matrix6* before) {
  std::vector<double> turn, shift, squared;
  for (const auto& r : residuals) turn.push_back(r.head<3>().norm()), shift.push_back(r.tail<3>().norm());
  Matrix6 scatter = Matrix6::Zero();
  if (before == nullptr || residuals.size() < kFewResiduals) {
    scatter.diagonal().head<3>().setConstant(std::pow(median(turn) / kMedianNorm3, 2));
    scatter.diagonal().tail<3>().setConstant(std::pow(median(shift) / kMedianNorm3, 2));
  } else {
    double sum = 0.0;
    for (const auto& r : residuals) {
      const double w = cauchy_weight((*before * r).squaredNorm(), kHandEyeCauchy);
      scatter += w * r * r.transpose();
      sum += w;
    }
    scatter /= std::max(sum, 1e-300);
  }
  // A floor far below any device's noise: perfect data must not make the scatter singular.
  scatter.diagonal().array() += 1e-16;
  const auto eigen = symmetric_eigen(scatter);
  Matrix6 W = eigen.vectors * eigen.values.cwiseMax(1e-17).cwiseSqrt().cwiseInverse().asDiagonal() *
              eigen.vectors.transpose();
  for (const auto& r : residuals) squared.push_back((W * r).squaredNorm());
  const double middle = median(squared);
  return middle > 1e-6 ? Matrix6(W * std::sqrt(kMedianChi2With6 / middle)) : W;
}

}  // namespace palpate::calibration
