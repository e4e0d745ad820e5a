// Where the camera sits before the eyes of who wears the headset, and by how much the headset's poses are late.
//
// Values; rad, m, s.
#pragma once

#include "palpate/math/headset_frames.h"
#include "palpate/math/pose.h"
#include "palpate/rig/provenance.h"

namespace palpate::rig {

struct HeadsetCalibration {
  Pose<HeadsetEyes, CameraOptical> X_eyes_camera;  // of two cameras the left one
  Matrix6 covariance = Matrix6::Zero();            // rotation (rad), then translation (m), HeadsetEyes axes
  // The headset was at an image's place at the image's time + this, by the runtime's poses.
  double delay_s = 0.0, delay_std_s = 0.0;
  Provenance from;
};

}  // namespace palpate::rig
