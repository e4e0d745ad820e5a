#include "palpate/vision/internal/fisheye_fit.h"

#include <cmath>
#include <limits>
#include <numbers>
#include <optional>

#include "palpate/core/text.h"
#include "palpate/math/pose_step.h"

namespace palpate::vision {
namespace {

constexpr Eigen::Index kFree = 8;        // fx fy cx cy k1 k2 k3 k4
constexpr double kNearestCorner = 1e-3;  // m; a corner nearer than this, or behind, has no pixel

using Equations = NormalEquations<Eigen::Dynamic>;

double cost_of_view(const device::CameraModel& lens, const BoardView& view,
                    const Pose<CameraOptical, Board>& X, Eigen::Index at, Equations* equations) {
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
    const Eigen::Matrix<double, 2, kFree> of_lens = device::lens_jacobian(lens, p).leftCols<kFree>();
    equations->JtJ.topLeftCorner<kFree, kFree>().noalias() += of_lens.transpose() * of_lens;
    equations->JtJ.block<6, kFree>(at, 0).noalias() += of_pose.transpose() * of_lens;  // the lower triangle
    equations->JtJ.block<6, 6>(at, at).noalias() += of_pose.transpose() * of_pose;
    equations->Jtr.head<kFree>().noalias() += of_lens.transpose() * r;
    equations->Jtr.segment<6>(at).noalias() += of_pose.transpose() * r;
  }
  return sum;
}

// From `fit` on, over the views that have a pose.
bool solve(const std::vector<const BoardView*>& views, FisheyeFit& fit) {
  const auto place = [](std::size_t i) { return kFree + 6 * static_cast<Eigen::Index>(i); };
  const Eigen::Index unknowns = place(views.size());
  const auto evaluate = [&](const FisheyeFit& at, Equations* equations) {
    if (equations != nullptr) equations->set_zero(unknowns);
    double sum = 0.0;
    for (std::size_t i = 0; i < views.size(); ++i)
      sum += cost_of_view(at.lens, *views[i], at.boards[i], place(i), equations);
    return sum;
  };
  const auto step_from = [&](const FisheyeFit& at, const Eigen::VectorXd& step) {
    device::LensParameters of_lens = device::LensParameters::Zero();
    of_lens.head<kFree>() = step.head<kFree>();
    FisheyeFit next{device::changed_lens(at.lens, of_lens), {}};
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

}  // namespace

Expected<FisheyeFit> fit_fisheye(const std::vector<BoardView>& views, int width, int height) {
  FisheyeFit fit;
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
  const auto astray = refused("the fit of the lens went astray; tilt the board differently in each view");
  if (!solve(with_pose, fit)) return astray;
  if (with_pose.size() == views.size()) return fit;
  // Those that the first lens could not place.
  FisheyeFit whole{fit.lens, {}};
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
  if (!solve(all, whole)) return astray;
  return whole;
}

}  // namespace palpate::vision
