// Transform sequences (.igs.mha): one of its transforms, and a chain of two.
#include "fuzz/check.h"
#include "palpate/calibration/pivot.h"
#include "palpate/device/pose_file.h"

namespace palpate::fuzz {

Refusals sequences(std::string_view file) {
  Refusals refusals;
  for (const char* transform : {"", "StylusToTracker", "StylusToReference"}) {
    if (file.find(transform) == std::string_view::npos) continue;
    const auto read = device::parse_poses(file, "sequence.igs.mha", {.transform = transform});
    if (!answered(read, refusals)) continue;
    std::vector<calibration::PivotPose> poses;
    for (const auto& pose : read->poses) {
      hold_finite(pose.time_s, "times read are finite");
      hold(std::abs(pose.rotation.norm() - 1.0) < 1e-6 && pose.translation.allFinite(),
           "poses read are rigid");
      if (poses.size() < kMostRows) poses.push_back({pose.rotation, pose.translation, 0, std::nullopt});
    }
    answered(calibration::calibrate_pivot(poses), refusals);
  }
  return refusals;
}

}  // namespace palpate::fuzz
