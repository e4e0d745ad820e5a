// The overlay error that a camera pose's own covariance promises: how far, in pixels, virtual points are
// likely to be drawn from the real ones they belong to.
//
// First order: a turn w and a shift d of the camera move the drawn place of a point p by J_p R' (hat(p - t) w
// - d). Rms over the points of the undistorted picture's standard deviation (of both axes together, as rms_px
// everywhere). It knows of no error that the covariance leaves out. World frame, m, rad, px. Pure.
#pragma once

#include <optional>
#include <span>

#include "palpate/model/camera.h"

namespace palpate {

// `covariance`: rotation (rad, World axes, left perturbation), then translation (m). Points behind the camera
// or outside of its picture do not count; none where that leaves nothing.
std::optional<double> stated_overlay_px(const CameraModel& camera,
                                        const Pose<World, CameraOptical>& X_world_camera,
                                        const Matrix6& covariance, std::span<const Vector3> points);

}  // namespace palpate
