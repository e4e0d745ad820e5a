#include "palpate/calibration/session/landmark_frames.h"

#include "palpate/device/marker_history.h"
#include "palpate/math/pose_step.h"

namespace palpate::calibration::session {

Expected<std::vector<TrackedFrame>> record_landmark_frames(AcquisitionContext context,
                                                           const rig::CameraCalibration& camera,
                                                           const rig::HandEyeCalibration& hand_eye,
                                                           const std::vector<rig::Landmark>& landmarks,
                                                           const LandmarkFrameOptions& options,
                                                           const FindLandmarks& find) {
  std::vector<device::CameraImage> images;
  const auto record = record_views(context, device::Gesture::look, options.seconds, options.every,
                                   [&](const device::CameraImage& image) {
                                     images.push_back(image);
                                     return true;
                                   });
  if (!record) return tl::unexpected(record.error());
  device::MarkerHistory history(seconds(0.1), seconds(1e4));
  for (const auto& pose : record->tracked)
    history.add({Instant<GraphicsClock>::from_seconds(pose.time_s), pose.marker.rotation,
                 pose.marker.translation, pose.marker.covariance});
  const auto marker_at = [&history](double t) { return history.at(Instant<GraphicsClock>::from_seconds(t)); };
  constexpr double kAside = 0.02;  // s before and after, for the rate
  std::vector<TrackedFrame> frames;
  for (std::size_t i = 0; i < images.size(); ++i) {
    const double t = record->image_times_s[i] - options.camera_after_tracker_s;
    const auto marker = marker_at(t), before = marker_at(t - kAside), after = marker_at(t + kAside);
    if (!marker) continue;
    TrackedFrame tracked;
    tracked.frame.X_world_marker = {marker->rotation, marker->translation};
    tracked.frame.covariance = marker->covariance;
    tracked.time_s = record->image_times_s[i];
    if (before && after)
      tracked.rate = math::deviation(Pose<World, CameraMarker>{after->rotation, after->translation},
                                     Pose<World, CameraMarker>{before->rotation, before->translation}) /
                     (2.0 * kAside);
    tracked.frame.sightings =
        find(images[i], camera, tracked.frame.X_world_marker * hand_eye.X_marker_camera, landmarks);
    frames.push_back(std::move(tracked));
  }
  return frames;
}

}  // namespace palpate::calibration::session
