// The overlay error: how far, in pixels of the drawn picture, a virtual point stands from the real one it
// belongs to.
//
// The drawn picture is undistorted with the ESTIMATED lens; virtual points are placed in it with the
// estimated lens and the estimated camera pose. A real point appears where the true camera puts it through
// the true lens, carried into the drawn picture by the estimated undistortion. World frame, metres; pixels as
// in CameraModel. Pure functions; they need the truth, so they belong to the report and to tests.
#pragma once

#include <optional>

#include "palpate/device/camera_model.h"
#include "palpate/math/pose.h"

namespace palpate::evaluation {

struct CameraView {
  device::CameraModel lens;
  Pose<World, CameraOptical> X_world_camera;
};

// Pixel of a virtual point in the drawn picture; empty behind the camera.
std::optional<device::Pixel> drawn_pixel(const CameraView& estimated, const Vector3& point);

// Pixel of a real point in the drawn picture; empty where the true camera does not see it.
std::optional<device::Pixel> real_pixel(const CameraView& truth, const device::CameraModel& estimated_lens,
                                        const Vector3& point);

// Length of the difference; empty where the real point is out of the picture.
std::optional<double> overlay_error(const CameraView& estimated, const Vector3& estimated_point,
                                    const CameraView& truth, const Vector3& true_point);

}  // namespace palpate::evaluation
