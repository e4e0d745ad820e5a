#include "palpate/calibration/session/session_plan.h"

#include "palpate/core/file.h"

namespace palpate::calibration::session {

rig::Provenance provenance(const CalibrationPlan& plan, const std::string& data, const std::string& method,
                           double rms_mm) {
  return {plan.date, content_hash(data), method, rms_mm};
}

std::string bytes_of(const std::vector<TrackedPose>& poses) {
  std::string bytes;
  for (const auto& pose : poses)
    bytes.append(reinterpret_cast<const char*>(pose.marker.translation.data()), 3 * sizeof(double));
  return bytes;
}

}  // namespace palpate::calibration::session
