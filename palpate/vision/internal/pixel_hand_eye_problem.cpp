#include "palpate/vision/internal/pixel_hand_eye_problem.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "palpate/math/linear_algebra.h"
#include "palpate/math/pose_step.h"

namespace palpate::vision {
namespace {

Vector6 prior_information(const PixelNoise& noise, double view_weight) {
  Vector6 information;
  information.head<3>().setConstant(view_weight / (noise.turn * noise.turn));
  information.tail<3>().setConstant(view_weight / (noise.place * noise.place));
  return information;
}

// Both entries of each corner.
Eigen::VectorXd per_entry(const Eigen::VectorXd& corner_weight, double sd) {
  Eigen::VectorXd result(2 * corner_weight.size());
  for (Eigen::Index i = 0; i < corner_weight.size(); ++i)
    result.segment<2>(2 * i).setConstant(corner_weight[i] / (sd * sd));
  return result;
}

}  // namespace

PixelState PixelState::moved(const Eigen::VectorXd& step) const {
  PixelState to = *this;
  to.X = math::moved(X, Vector6(step.head<6>()));
  to.Z = math::moved(Z, Vector6(step.segment<6>(6)));
  to.delay_s += step[kDelayAt];
  to.lens = device::changed_lens(lens, step.segment<device::kLensParameters>(kLensAt));
  to.scale += step[kScaleAt];
  return to;
}

std::optional<PixelProblem::Hand> PixelProblem::hand_at(double t) const {
  const auto next = std::lower_bound(hand.begin(), hand.end(), t,
                                     [](const auto& pose, double s) { return pose.time_s < s; });
  if (next == hand.end() || (next == hand.begin() && next->time_s > t) || hand.size() < 2)
    return std::nullopt;
  const auto& b = next == hand.begin() ? *(next + 1) : *next;
  const auto& a = next == hand.begin() ? *next : *(next - 1);
  const double gap = b.time_s - a.time_s;
  if (gap > max_hand_gap_s) return std::nullopt;
  Hand at;
  at.pose = interpolate(a.as<World, CameraMarker>(), b.as<World, CameraMarker>(), (t - a.time_s) / gap);
  at.w = so3_log(b.rotation * a.rotation.conjugate()) / gap;
  at.v = (b.translation - a.translation) / gap;
  return at;
}

bool PixelProblem::linearise(const PixelState& x, std::size_t index, View& out) const {
  const auto& view = views[index];
  const auto at = hand_at(time_s[index] + x.delay_s);
  if (!at) return false;
  const auto n = static_cast<Eigen::Index>(view.board.size());
  out.r.resize(2 * n);
  out.J.setZero(2 * n, kPixelUnknowns);
  out.G.setZero(2 * n, 6);
  const Matrix3 Rx = x.X.matrix().transpose(), to_camera = Rx * at->pose.matrix().transpose(),
                Rz = x.Z.matrix();
  for (Eigen::Index i = 0; i < n; ++i) {
    const Vector3& b = view.board[static_cast<std::size_t>(i)];
    const Vector3 turned = x.scale * (Rz * b), arm = turned + x.Z.translation - at->pose.translation;
    const Vector3 in_marker = at->pose.matrix().transpose() * arm - x.X.translation, p = Rx * in_marker;
    if (!(p.z() > device::kNearestSeen)) return false;
    Eigen::Matrix<double, 2, 3> P;
    out.r.segment<2>(2 * i) = device::project(x.lens, p, P) - view.image[static_cast<std::size_t>(i)];
    auto J = out.J.middleRows<2>(2 * i);
    auto G = out.G.middleRows<2>(2 * i);
    J.leftCols<3>() = P * Rx * hat(in_marker);
    J.middleCols<3>(3) = -P * Rx;
    J.middleCols<3>(6) = -P * to_camera * hat(turned);
    J.middleCols<3>(9) = P * to_camera;
    G.leftCols<3>() = P * to_camera * hat(arm);
    G.rightCols<3>() = -P * to_camera;
    J.col(kDelayAt) = G.leftCols<3>() * at->w + G.rightCols<3>() * at->v;
    J.middleCols<device::kLensParameters>(kLensAt) = device::lens_jacobian(x.lens, p);
    J.col(kScaleAt) = P * to_camera * (Rz * b);
  }
  for (Eigen::Index k = 0; k < kPixelUnknowns; ++k)
    if (!free[k]) out.J.col(k).setZero();
  return true;
}

double PixelProblem::evaluate(const PixelState& x, const PixelNoise& noise,
                              NormalEquations<Eigen::Dynamic>* equations) const {
  if (equations) equations->set_zero(kPixelUnknowns);
  double cost = 0.0;
  int used = 0;
  View view;
  for (std::size_t i = 0; i < views.size(); ++i) {
    if (!linearise(x, i, view)) {
      // Between the hand's poses a view may be missed; behind the camera no corner may be.
      if (hand_at(time_s[i] + x.delay_s)) return std::numeric_limits<double>::infinity();
      continue;
    }
    ++used;
    const Eigen::VectorXd w = per_entry(noise.corner_weight[i], noise.corner);
    const Eigen::MatrixXd WG = w.asDiagonal() * view.G;
    Matrix6 A = view.G.transpose() * WG;
    A.diagonal() += prior_information(noise, noise.view_weight[i]);
    const Eigen::MatrixXd inverse = inverse_symmetric(A);
    const Vector6 Gr = WG.transpose() * view.r;
    cost += view.r.dot(w.cwiseProduct(view.r)) - Gr.dot(inverse * Gr);
    if (!equations) continue;
    const Eigen::MatrixXd GJ = WG.transpose() * view.J;
    equations->JtJ += view.J.transpose() * w.asDiagonal() * view.J - GJ.transpose() * inverse * GJ;
    equations->Jtr += view.J.transpose() * w.cwiseProduct(view.r) - GJ.transpose() * (inverse * Gr);
  }
  // The mean over the views, so that delays at which fewer count are not favoured.
  if (used == 0) return std::numeric_limits<double>::infinity();
  if (equations) equations->JtJ /= used, equations->Jtr /= used;
  return cost / used;
}

LeastSquaresResult PixelProblem::solve(PixelState& x, const PixelNoise& noise, int most_iterations) const {
  return minimise_with(
      NormalEquations<Eigen::Dynamic>(kPixelUnknowns), x,
      [&](const PixelState& at, NormalEquations<Eigen::Dynamic>* equations) {
        return evaluate(at, noise, equations);
      },
      [](const PixelState& at, const Eigen::VectorXd& step) { return at.moved(step); },
      {.most_iterations = most_iterations});
}

HandError hand_error(const PixelProblem::View& view, const Eigen::VectorXd& corner_weight, double view_weight,
                     const PixelNoise& noise) {
  const Eigen::VectorXd w = per_entry(corner_weight, noise.corner);
  const Eigen::MatrixXd WG = w.asDiagonal() * view.G;
  Matrix6 A = view.G.transpose() * WG;
  A.diagonal() += prior_information(noise, view_weight);
  HandError error;
  error.covariance = inverse_symmetric(A);
  error.mean = -error.covariance * (WG.transpose() * view.r);
  error.left = view.r + view.G * error.mean;
  return error;
}

}  // namespace palpate::vision
