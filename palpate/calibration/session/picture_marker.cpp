#include "palpate/calibration/session/picture_marker.h"

namespace palpate::calibration::session {

void PictureMarker::watch(double now_s, std::span<const device::TrackerSample> tracked) {
  const auto now = Instant<GraphicsClock>::from_seconds(now_s);
  const Duration waited = seconds(now_s - watched_s_.value_or(now_s));
  watched_s_ = now_s;
  for (const auto& sample : tracked) {
    if (sample.marker != device::MarkerId::camera_marker) continue;
    tracker_clock_.add(sample.stamp, now - sample.waited, waited);
    if (!sample.seen) continue;
    history_.add(
        {tracker_clock_.model().to(sample.stamp), sample.rotation, sample.translation, sample.covariance});
  }
}

SeenMarker PictureMarker::at(const device::CameraImage& image, double now_s, double camera_after_tracker_s) {
  camera_clock_.add(image.mid_exposure, Instant<GraphicsClock>::from_seconds(now_s) - image.waited);
  const auto taken = camera_clock_.model().to(image.mid_exposure) - seconds(camera_after_tracker_s);
  auto marker = history_.at(taken);
  // The tracker's sample may be on its way yet.
  if (!marker) marker = history_.predict(taken);
  if (!marker) return {};
  return {true, false, marker->rotation, marker->translation};
}

}  // namespace palpate::calibration::session
