// Boards and views made from a known truth, for tests only: no test of ours trusts what it did not draw
// itself.
#pragma once

#include <cmath>
#include <cstdint>
#include <string>
#include <vector>

#include "palpate/core/random.h"
#include "palpate/vision/board.h"

namespace palpate::vision::synthetic {

// A chessboard seen through the lens, anti-aliased by 4 x 4 rays a pixel; white margin, grey background.
inline std::vector<std::uint8_t> draw_board(const device::CameraModel& camera,
                                            const Pose<CameraOptical, Board>& X, const BoardShape& shape) {
  constexpr int kRays = 4;
  std::vector<std::uint8_t> grey;
  const auto inverse = X.inverse();
  for (int v = 0; v < camera.height; ++v)
    for (int u = 0; u < camera.width; ++u) {
      double sum = 0.0;
      for (int k = 0; k < kRays * kRays; ++k) {
        const double du = (k % kRays + 0.5) / kRays - 0.5, dv = (k / kRays + 0.5) / kRays - 0.5;
        const auto n = camera.undistort({(u + du - camera.cx) / camera.fx, (v + dv - camera.cy) / camera.fy});
        double shade = 110.0;
        if (n) {
          const Vector3 ray = inverse.rotation * Vector3(n->x(), n->y(), 1.0);
          const Vector3 hit = inverse.translation - inverse.translation.z() / ray.z() * ray;
          const double i = std::floor(hit.x() / shape.square), j = std::floor(hit.y() / shape.square);
          if (i >= -2 && j >= -2 && i <= shape.columns && j <= shape.rows) {
            const bool margin = i < -1 || j < -1 || i > shape.columns - 1 || j > shape.rows - 1;
            shade = margin || std::fmod(i + j + 8, 2.0) != 0 ? 220.0 : 30.0;
          }
        }
        sum += shade;
      }
      grey.push_back(static_cast<std::uint8_t>(std::lround(sum / (kRays * kRays))));
    }
  return grey;
}

// The board somewhere in front of the camera, tilted up to 40 degrees, all corners in the image.
inline Pose<CameraOptical, Board> board_in_view(const device::CameraModel& camera, const BoardShape& shape,
                                                Random& random) {
  const Vector3 middle = 0.5 * shape.corner(shape.corners() - 1);
  while (true) {
    const Quaternion R =
        so3_exp(Vector3(random.uniform(-0.7, 0.7), random.uniform(-0.7, 0.7), random.uniform(-0.5, 0.5)));
    const double z = random.uniform(0.3, 0.7);
    const Pose<CameraOptical, Board> X{
        R, Vector3(random.uniform(-0.4, 0.4) * z, random.uniform(-0.3, 0.3) * z, z) - R * middle};
    bool inside = true;
    for (int i = 0; i < shape.corners(); ++i) {
      const Vector3 p = X.rotation * shape.corner(i) + X.translation;
      const device::Pixel u = camera.project(p);
      inside = inside && p.z() > 0.1 && u.x() > 5 && u.y() > 5 && u.x() < camera.width - 6 &&
               u.y() < camera.height - 6;
    }
    if (inside) return X;
  }
}

inline BoardView view_of(const device::CameraModel& camera, const Pose<CameraOptical, Board>& X,
                         const BoardShape& shape, double noise_px, Random& random,
                         std::string name = "view") {
  BoardView view{std::move(name), {}, {}};
  for (int i = 0; i < shape.corners(); ++i) {
    view.board.push_back(shape.corner(i));
    view.image.push_back(camera.project(X.rotation * shape.corner(i) + X.translation) +
                         device::Pixel(random.normal(noise_px), random.normal(noise_px)));
  }
  return view;
}

}  // namespace palpate::vision::synthetic
