#include "palpate/calibration/session/reference_body.h"

namespace palpate::calibration::session {
namespace {

device::TrackerSample seen_from(const device::TrackerSample& body, const device::TrackerSample& marker) {
  device::TrackerSample relative = marker;
  const Matrix3 to_body = body.rotation.conjugate().toRotationMatrix();
  const Vector3 between = marker.translation - body.translation;
  relative.rotation = (body.rotation.conjugate() * marker.rotation).normalized();
  relative.translation = to_body * between;
  Matrix6 of_marker = Matrix6::Zero(), of_body = Matrix6::Zero();
  of_marker.topLeftCorner<3, 3>() = to_body;
  of_marker.bottomRightCorner<3, 3>() = to_body;
  of_body.topLeftCorner<3, 3>() = -to_body;
  of_body.bottomLeftCorner<3, 3>() = to_body * hat(between);
  of_body.bottomRightCorner<3, 3>() = -to_body;
  relative.covariance =
      of_marker * marker.covariance * of_marker.transpose() + of_body * body.covariance * of_body.transpose();
  relative.systematic = to_body * (marker.systematic + body.systematic) * to_body.transpose();
  relative.leds = std::min(marker.leds, body.leds);
  return relative;
}

}  // namespace

std::vector<TrackedPose> in_reference(const std::vector<TrackedPose>& poses,
                                      const std::vector<TrackedPose>& reference) {
  std::vector<TrackedPose> relative = poses;
  for (auto& pose : relative) {
    const auto body = device::pose_between(reference, pose.time_s);
    pose.marker.seen = pose.marker.seen && body;
    if (pose.marker.seen) pose.marker = seen_from(body->marker, pose.marker);
  }
  return relative;
}

}  // namespace palpate::calibration::session
