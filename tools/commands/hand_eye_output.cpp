#include "tools/commands/hand_eye_output.h"

#include <utility>

#include "palpate/core/file.h"
#include "palpate/core/units.h"
#include "tools/commands/result_output.h"

namespace palpate::tools::commands {

Expected<PosePair> read_pose_pair(const std::string& hand, const std::string& eye,
                                  const std::string& expected) {
  auto first = device::read_poses(hand);
  if (!first) return tl::unexpected(first.error());
  auto second = device::read_poses(eye);
  if (!second) return tl::unexpected(second.error());
  if (first->hash == second->hash)
    return wrong_use("{}: holds the same as {}; {} are expected", eye, hand, expected);
  std::string hash = content_hash(first->hash + second->hash);
  return PosePair{std::move(*first), std::move(*second), std::move(hash)};
}

Json hand_eye_json(const calibration::HandEyeSolution& found) {
  Json json;
  json["translation_mm"] = json_list(found.X_marker_camera.translation, kMm);
  json["rotation_qwxyz"] = json_quaternion(found.X_marker_camera.rotation);
  json["delay_s"] = found.delay_s;
  json["delay_std_s"] = found.delay_std_s;
  json["rotation_residual_median_deg"] = degrees_from_radians(found.rotation_residual_median);
  json["translation_residual_median_mm"] = kMm * found.translation_residual_median;
  return json;
}

Json hand_eye_std_json(const Estimate<calibration::HandEyeSolution>& fit) {
  const auto sd = standard_deviations(fit.covariance);
  return {{"rotation_deg", json_list(sd.segment<3>(0), kDegreesPerRadian)},
          {"translation_mm", json_list(sd.segment<3>(3), kMm)},
          {"delay_s", fit.value.delay_std_s}};
}

}  // namespace palpate::tools::commands
