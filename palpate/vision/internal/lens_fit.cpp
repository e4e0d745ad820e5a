#include "palpate/vision/internal/lens_fit.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>

#include "palpate/core/text.h"
#include "palpate/math/pose_step.h"

namespace palpate::vision {
namespace {

constexpr double kNearestCorner = 1e-3;  // m; a corner nearer than this, or behind, has no pixel

using Equations = NormalEquations<Eigen::Dynamic>;

Eigen::Index free_parameters(device::LensKind kind) {
  return 4 + static_cast<Eigen::Index>(device::coefficient_count(kind));
}

double cost_of_view(const device::CameraModel& lens, const BoardView& view,
                    const Pose<CameraOptical, Board>& X, Eigen::Index at, Equations* equations) {
  const Eigen::Index n = free_parameters(lens.kind);
  double sum = 0.0;
  for (std::size_t j = 0; j < view.board.size(); ++j) {
    const Vector3 turned = X.rotation * view.board[j], p = turned + X.translation;
    if (!(p.z() > kNearestCorner)) return std::numeric_limits<double>::infinity();
    Eigen::Matrix<double, 2, 3> J;
    const Eigen::Vector2d r = device::project(lens, p, J) - view.image[j];
    sum += r.squaredNorm();
    if (equations == nullptr) continue;
    Eigen::Matrix<double, 2, 6> of_pose;
    of_pose << -J * hat(turned), J;
    const Eigen::Matrix<double, 2, device::kLensParameters> all = device::lens_jacobian(lens, p);
    const auto of_lens = all.leftCols(n);
    equations->JtJ.topLeftCorner(n, n).noalias() += of_lens.transpose() * of_lens;
    equations->JtJ.block(at, 0, 6, n).noalias() += of_pose.transpose() * of_lens;  // the lower triangle
    equations->JtJ.block<6, 6>(at, at).noalias() += of_pose.transpose() * of_pose;
    equations->Jtr.head(n).noalias() += of_lens.transpose() * r;
    equations->Jtr.segment<6>(at).noalias() += of_pose.transpose() * r;
  }
  return std::isfinite(sum) ? sum : std::numeric_limits<double>::infinity();
}

double cost_of_prior(const device::CameraModel& lens, const device::LensParameters& information,
                     Equations* equations) {
  double sum = 0.0;
  for (std::size_t k = 0; k < lens.distortion.size(); ++k) {
    const auto i = 4 + static_cast<Eigen::Index>(k);
    sum += information[i] * lens.distortion[k] * lens.distortion[k];
    if (equations == nullptr || information[i] == 0.0) continue;
    equations->JtJ(i, i) += information[i];
    equations->Jtr[i] += information[i] * lens.distortion[k];
  }
  return sum;
}

// From `fit` on, over the views that have a pose.
bool solve(const std::vector<const BoardView*>& views, LensFit& fit) {
  double farthest = 0.0;
  for (std::size_t i = 0; i < views.size(); ++i)
    farthest = std::max(farthest, farthest_seen(*views[i], fit.boards[i]));
  const auto prior = lens_prior(fit.lens.kind, farthest);
  const Eigen::Index n = free_parameters(fit.lens.kind);
  const auto place = [n](std::size_t i) { return n + 6 * static_cast<Eigen::Index>(i); };
  const Eigen::Index unknowns = place(views.size());
  const auto evaluate = [&](const LensFit& at, Equations* equations) {
    if (equations != nullptr) equations->set_zero(unknowns);
    double sum = cost_of_prior(at.lens, prior, equations);
    for (std::size_t i = 0; i < views.size(); ++i)
      sum += cost_of_view(at.lens, *views[i], at.boards[i], place(i), equations);
    return sum;
  };
  const auto step_from = [&](const LensFit& at, const Eigen::VectorXd& step) {
    device::LensParameters of_lens = device::LensParameters::Zero();
    of_lens.head(n) = step.head(n);
    LensFit next{device::changed_lens(at.lens, of_lens), {}};
    for (std::size_t i = 0; i < views.size(); ++i)
      next.boards.push_back(moved<CameraOptical, Board>(at.boards[i], step.segment<6>(place(i))));
    return next;
  };
  const auto solved = minimise_with(Equations(unknowns), fit, evaluate, step_from, {.most_iterations = 200});
  return std::isfinite(solved.cost);
}

std::vector<std::optional<Pose<CameraOptical, Board>>> poses_under(const device::CameraModel& lens,
                                                                   const std::vector<BoardView>& views,
                                                                   double& error) {
  constexpr double kWithoutPose = 1e4;  // px^2 a corner: a lens that leaves views without a pose is no start
  std::vector<std::optional<Pose<CameraOptical, Board>>> poses;
  error = 0.0;
  for (const auto& view : views) {
    const auto pose = board_pose(lens, view, {.max_rms_px = std::numeric_limits<double>::infinity()});
    poses.push_back(pose ? std::optional(pose->value.X_camera_board) : std::nullopt);
    error += pose ? std::pow(pose->value.rms_px, 2) : kWithoutPose;
  }
  return poses;
}

tl::unexpected<Error> astray() {
  return refused("the fit of the lens went astray; tilt the board differently in each view");
}

}  // namespace

device::LensParameters lens_prior(device::LensKind kind, double farthest) {
  constexpr double kTerm = 2.0, kCorner = 0.1;  // at `farthest`; px, to which a corner is found
  device::LensParameters information = device::LensParameters::Zero();
  if (kind != device::LensKind::rational) return information;
  const double r2 = std::max(farthest * farthest, 1e-6);
  const auto at = [&](double power) { return std::pow(kCorner * std::pow(r2, power) / kTerm, 2); };
  information[4] = information[9] = at(1.0);   // k1, k4
  information[5] = information[10] = at(2.0);  // k2, k5
  information[8] = information[11] = at(3.0);  // k3, k6
  return information;
}

double farthest_seen(const BoardView& view, const Pose<CameraOptical, Board>& X) {
  double farthest = 0.0;
  for (const auto& corner : view.board) {
    const Vector3 p = X.rotation * corner + X.translation;
    if (p.z() > kNearestCorner) farthest = std::max(farthest, p.head<2>().norm() / p.z());
  }
  return farthest;
}

Expected<LensFit> fit_rational(const std::vector<BoardView>& views, LensFit start) {
  std::vector<const BoardView*> all;
  for (const auto& view : views) all.push_back(&view);
  start.lens.kind = device::LensKind::rational;
  if (!solve(all, start)) return astray();
  return start;
}

Expected<LensFit> fit_fisheye(const std::vector<BoardView>& views, int width, int height) {
  LensFit fit;
  std::vector<std::optional<Pose<CameraOptical, Board>>> start;
  double least = std::numeric_limits<double>::infinity();
  // From corner to corner 250 down to 70 deg.
  for (double degrees = 250.0; degrees >= 70.0; degrees /= 1.15) {
    device::CameraModel lens;
    lens.width = width, lens.height = height, lens.kind = device::LensKind::fisheye;
    lens.cx = 0.5 * (width - 1), lens.cy = 0.5 * (height - 1);
    lens.fx = lens.fy = std::hypot(width, height) / (degrees * std::numbers::pi / 180.0);
    double error = 0.0;
    auto poses = poses_under(lens, views, error);
    if (error < least) least = error, fit.lens = lens, start = std::move(poses);
  }
  std::vector<const BoardView*> with_pose;
  for (std::size_t i = 0; i < start.size(); ++i)
    if (start[i]) with_pose.push_back(&views[i]), fit.boards.push_back(*start[i]);
  if (with_pose.size() < 3)
    return refused("the board's pose is found in {} only; show it nearer, and in the middle of the image too",
                   counted(with_pose.size(), "view"));
  if (!solve(with_pose, fit)) return astray();
  if (with_pose.size() == views.size()) return fit;
  // Those that the first lens could not place.
  LensFit whole{fit.lens, {}};
  std::vector<const BoardView*> all;
  std::size_t next = 0;
  for (std::size_t i = 0; i < views.size(); ++i) {
    all.push_back(&views[i]);
    if (start[i]) {
      whole.boards.push_back(fit.boards[next++]);
      continue;
    }
    const auto pose = board_pose(fit.lens, views[i], {.max_rms_px = std::numeric_limits<double>::infinity()});
    if (!pose) return tl::unexpected(pose.error());
    whole.boards.push_back(pose->value.X_camera_board);
  }
  if (!solve(all, whole)) return astray();
  return whole;
}

}  // namespace palpate::vision
