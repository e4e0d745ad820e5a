// For tests: what a camera sees of the simulated laboratory, drawn by the simulated camera's own renderer.
#pragma once

#include <vector>

#include "palpate/core/random.h"
#include "palpate/sim/board_view.h"
#include "palpate/sim/camera_renderer.h"

namespace palpate {

inline const device::CameraModel kTestLens{
    640, 480, 560, 561.5, 318.7, 242.1, {-0.28, 0.09, 0.001, -0.0005, 0.0}};

inline sim::TrueView laboratory_view() {
  sim::TrueView view;
  view.lens = kTestLens;
  const Vector3 eye(0, -0.95, 2.30), z = (Vector3(0, -1.45, 1.40) - eye).normalized();
  const Vector3 x = z.cross(Vector3::UnitY()).normalized();
  Matrix3 R;
  R << x, z.cross(x), z;
  view.X_world_camera = {Quaternion(R), eye};
  view.table = {Vector3(-0.375, -1.52, 1.8), Vector3(0.375, -1.52, 1.8), Vector3(0.375, -1.52, 0.8),
                Vector3(-0.375, -1.52, 0.8)};
  view.wall = {Vector3(-0.375, -1.52, 0.8), Vector3(0.375, -1.52, 0.8), Vector3(0.375, -0.92, 0.8),
               Vector3(-0.375, -0.92, 0.8)};
  for (const double at : {-0.34, -0.2, 0.34}) view.dots.push_back({{at, -1.52, 0.95}, Vector3::UnitY()});
  view.X_world_base = {Quaternion::Identity(), {0.10, -1.40, 1.75}};
  view.theta = {0.1, 0.3, 0.2};
  view.X_tip_marker = {Quaternion::Identity(), {-0.004, 0.018, 0.118}};
  view.marker_leds = {{0.06, 0, 0}, {-0.03, 0.052, 0}, {-0.03, -0.052, 0}};
  return view;
}

// The arm in so many places, or a calibration board held up in so many ways.
inline std::vector<std::vector<std::uint8_t>> rendered_views(int count, bool board) {
  sim::CameraRenderer renderer;
  Random random(1, "rendered views");
  const auto poses =
      board ? sim::board_poses(kTestLens, count, random) : std::vector<Pose<CameraOptical, Board>>();
  std::vector<std::vector<std::uint8_t>> pictures(static_cast<std::size_t>(count));
  for (int i = 0; i < count; ++i) {
    auto view = laboratory_view();
    view.theta.x() += 0.1 * i;
    if (board)
      view.X_world_base.translation.x() += 3.0,
          view.board = view.X_world_camera * poses[static_cast<std::size_t>(i)];
    view.noise_sd = 1.0, view.noise_seed = static_cast<std::uint64_t>(i);
    renderer.render(view, pictures[static_cast<std::size_t>(i)]);
  }
  return pictures;
}

}  // namespace palpate
