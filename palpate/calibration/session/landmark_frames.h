// Pictures of the landmarks from a moving head, each with its marker's tracked pose at the moment it was taken.
//
// World frame, SI, px. One thread. Errors: the recording's.
#pragma once

#include <functional>
#include <vector>

#include "palpate/calibration/session/procedures.h"
#include "palpate/rig/rig.h"
#include "palpate/vision/landmark_refinement.h"

namespace palpate::calibration::session {

// Finds landmarks in an image: predicted from the camera's pose, as the compositor's detector does it. The
// sightings state their covariance.
using FindLandmarks = std::function<std::vector<vision::Sighting>(
    const device::CameraImage&, const rig::CameraCalibration&, const Pose<World, CameraOptical>&,
    const std::vector<rig::Landmark>&)>;

struct TrackedFrame {
  vision::LandmarkFrame frame;
  Vector6 rate = Vector6::Zero();  // of the marker: rad/s (World, left perturbation), m/s
  double time_s = 0.0;             // of the picture, host time as its stamps have it
};

struct LandmarkFrameOptions {
  double seconds = 5.0;
  int every = 3;                        // one image in so many: neighbours say the same again
  double camera_after_tracker_s = 0.0;  // as rig::DelayCalibration has it
};

Expected<std::vector<TrackedFrame>> record_landmark_frames(AcquisitionContext context,
                                                           const rig::CameraCalibration& camera,
                                                           const rig::HandEyeCalibration& hand_eye,
                                                           const std::vector<rig::Landmark>& landmarks,
                                                           const LandmarkFrameOptions& options,
                                                           const FindLandmarks& find);

}  // namespace palpate::calibration::session
