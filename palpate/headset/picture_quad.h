// The rectangle in front of a camera that its undistorted picture covers at a given depth: where a picture has to
// stand so that each of its pixels lies on the ray it was seen along.
//
// CameraOptical and Panel frames, metres. Pure functions.
#pragma once

#include "palpate/device/camera_model.h"
#include "palpate/headset/frames.h"
#include "palpate/math/pose.h"

namespace palpate::headset {

struct PictureQuad {
  Pose<CameraOptical, Panel> X_camera_panel;
  double width = 0.0, height = 0.0;  // m, over the outer edges of the outermost pixels
};

// `depth` along the optical axis; needs depth > 0.
PictureQuad picture_quad(const device::CameraModel& camera, double depth);

// A camera in the middle of the head that looks where the head does: what holds until somebody has calibrated it.
Pose<View, CameraOptical> camera_between_the_eyes();

}  // namespace palpate::headset
