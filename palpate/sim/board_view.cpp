#include "palpate/sim/board_view.h"

namespace palpate::sim {

std::optional<std::vector<device::Pixel>> board_corners(const device::CameraModel& lens,
                                                        const Pose<CameraOptical, Board>& X_camera_board,
                                                        double noise_sd, Random& random) {
  std::vector<device::Pixel> pixels;
  pixels.reserve(static_cast<std::size_t>(kBoardColumns * kBoardRows));
  bool inside = true;
  for (int row = 0; row < kBoardRows; ++row) {
    for (int column = 0; column < kBoardColumns; ++column) {
      const Vector3 p = (X_camera_board * Point<Board>{{column * kBoardSquare, row * kBoardSquare, 0.0}}).m;
      const double u = random.normal(noise_sd), v = random.normal(noise_sd);
      if (p.z() < 0.05) {
        inside = false;
        continue;
      }
      const device::Pixel seen = lens.project(p);
      // The lens model folds back far outside the picture; the ideal pinhole tells such places from real
      // ones.
      const device::Pixel ideal = lens.project_undistorted(p);
      inside = inside && seen.x() > kPictureMargin && seen.y() > kPictureMargin &&
               seen.x() < lens.width - 1 - kPictureMargin && seen.y() < lens.height - 1 - kPictureMargin &&
               std::abs(ideal.x() - lens.cx) < lens.width && std::abs(ideal.y() - lens.cy) < lens.height;
      pixels.emplace_back(seen.x() + u, seen.y() + v);
    }
  }
  if (!inside) return std::nullopt;
  return pixels;
}

std::vector<Pose<CameraOptical, Board>> board_poses(const device::CameraModel& lens, int count,
                                                    Random& random) {
  std::vector<Pose<CameraOptical, Board>> poses;
  const Vector3 middle(0.5 * (kBoardColumns - 1) * kBoardSquare, 0.5 * (kBoardRows - 1) * kBoardSquare, 0.0);
  for (int attempt = 0; attempt < 10000 * count && static_cast<int>(poses.size()) < count; ++attempt) {
    const double distance = random.uniform(0.25, 0.6), across = random.uniform(-0.4, 0.4),
                 down = random.uniform(-0.3, 0.3);
    const double tilt_x = random.uniform(-0.6, 0.6), tilt_y = random.uniform(-0.6, 0.6),
                 roll = random.uniform(-0.5, 0.5);
    const Quaternion turn = rotation_from_xyz({tilt_x, tilt_y, roll});
    const Vector3 place = distance * Vector3(across, down, 1.0);
    const Pose<CameraOptical, Board> pose{turn, place - turn * middle};
    Random none(0);
    if (board_corners(lens, pose, 0.0, none)) poses.push_back(pose);
  }
  return poses;
}

}  // namespace palpate::sim
