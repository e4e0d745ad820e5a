// Landmarks found in a picture as the estimators take them: places with their covariance, as the detector
// states them. Pure functions, any thread.
#pragma once

#include <vector>

#include "palpate/device/devices.h"
#include "palpate/rig/rig.h"
#include "palpate/vision/pose_refinement.h"

namespace palpate::vision {

// Each near the place where the camera's pose says it should appear.
std::vector<Sighting> find_sightings(const device::CameraImage& image, const rig::CameraCalibration& camera,
                                     const Pose<World, CameraOptical>& X_world_camera,
                                     const std::vector<rig::Landmark>& landmarks);

}  // namespace palpate::vision
