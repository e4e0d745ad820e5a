// The pixels of a picture that things cover, as a rectangle. Pure.
#pragma once

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>

#include "palpate/device/camera_model.h"
#include "palpate/math/pose.h"

namespace palpate::render {

using WorldBox = Eigen::AlignedBox3d;
inline constexpr double kNearest = 0.03;  // m, in front of the camera: what is nearer is not drawn

// Pixels of the picture that something covers; grows.
struct PixelBox {
  double left = 1e9, above = 1e9, right = -1e9, below = -1e9;
  bool everything = false;
  void take(const device::CameraModel& camera, const Vector3& p) {
    if (p.z() < kNearest) {
      everything = true;
      return;
    }
    const device::Pixel pixel = camera.project_undistorted(p);
    left = std::min(left, pixel.x()), right = std::max(right, pixel.x());
    above = std::min(above, pixel.y()), below = std::max(below, pixel.y());
  }
  void take(const device::CameraModel& camera, const Pose<CameraOptical, World>& X, const WorldBox& box) {
    if (box.isEmpty()) return;
    for (int i = 0; i < 8; ++i)
      take(camera, (X * Point<World>{box.corner(static_cast<WorldBox::CornerType>(i))}).m);
  }
  // x, y, width, height, cut to the picture.
  std::array<int, 4> pixels(const device::CameraModel& camera) const {
    if (everything) return {0, 0, camera.width, camera.height};
    const auto whole = [](double x, int most) {
      return static_cast<int>(std::clamp(x, 0.0, static_cast<double>(most)));
    };
    const int l = whole(std::floor(left) - 2, camera.width), a = whole(std::floor(above) - 2, camera.height);
    const int r = whole(std::ceil(right) + 3, camera.width), b = whole(std::ceil(below) + 3, camera.height);
    return {l, a, std::max(0, r - l), std::max(0, b - a)};
  }
};

}  // namespace palpate::render
