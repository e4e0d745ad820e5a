#include "palpate/calibration/session/session_plan.h"

#include "palpate/core/file.h"

namespace palpate::calibration::session {

rig::Provenance provenance(const CalibrationPlan& plan, const std::string& data, const std::string& method,
                           double rms_mm) {
  return {plan.now ? plan.now() : "", content_hash(data), method, rms_mm};
}

namespace {

void append(std::string& bytes, const Vector3& place) {
  bytes.append(reinterpret_cast<const char*>(place.data()), 3 * sizeof(double));
}

}  // namespace

std::string bytes_of(const std::vector<TrackedPose>& poses) {
  std::string bytes;
  for (const auto& pose : poses) append(bytes, pose.marker.translation);
  return bytes;
}

std::string bytes_of(const std::vector<TouchedPoint>& touches) {
  std::string bytes;
  for (const auto& touch : touches) append(bytes, touch.place);
  return bytes;
}

}  // namespace palpate::calibration::session
