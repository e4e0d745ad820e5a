#include "palpate/vision/sightings.h"

#include "palpate/vision/landmark_detector.h"

namespace palpate::vision {

std::vector<Sighting> find_sightings(const device::CameraImage& image, const rig::CameraCalibration& camera,
                                     const Pose<World, CameraOptical>& X_world_camera,
                                     const std::vector<rig::Landmark>& landmarks) {
  std::vector<Sighting> sightings;
  for (const auto& seen :
       detect_landmarks(image, camera.model, X_world_camera, landmarks, {.encoding = camera.encoding}))
    sightings.push_back({seen.landmark, seen.centre, seen.covariance});
  return sightings;
}

}  // namespace palpate::vision
