// The direction each pixel of a camera looks along: the lens model inverted once for all pixels. Pure
// functions.
#pragma once

#include <Eigen/Core>
#include <array>
#include <vector>

#include "palpate/device/camera_model.h"

namespace palpate::sim {

struct LensRays {
  std::vector<Eigen::Vector2f>
      ray;                    // x/z, y/z in CameraOptical, row by row; where the lens folds back: far outside
  Eigen::Vector2d low, high;  // range of the rays that exist
};

LensRays lens_rays(const device::CameraModel& lens);

// Smallest box of pixels (x, y, width, height; cut to the picture) that holds a convex flat polygon given in
// CameraOptical; width 0 where nothing of it lies in front of the camera. Up to a few pixels too large.
std::array<int, 4> pixel_box(const device::CameraModel& lens, const std::vector<Vector3>& polygon);

}  // namespace palpate::sim
