#include "palpate/calibration/findings/hand_eye.h"

#include <algorithm>

namespace palpate::calibration::findings {

Json hand_eye_place_json(const HandEyeSolution& found) {
  Json json;
  json["translation_mm"] = json_list(found.X_marker_camera.translation, kMm);
  json["rotation_qwxyz"] = json_quaternion(found.X_marker_camera.rotation);
  json["delay_s"] = found.delay_s;
  json["delay_std_s"] = found.delay_std_s;
  json["rotation_residual_median_deg"] = degrees_from_radians(found.rotation_residual_median);
  json["translation_residual_median_mm"] = kMm * found.translation_residual_median;
  return json;
}

Json hand_eye_std_json(const Estimate<HandEyeSolution>& fit) {
  const auto sd = standard_deviations(fit.covariance);
  return {{"rotation_deg", json_list(sd.segment<3>(0), kDegreesPerRadian)},
          {"translation_mm", json_list(sd.segment<3>(3), kMm)},
          {"delay_s", fit.value.delay_std_s}};
}

Json hand_eye_json(const Estimate<HandEyeSolution>& fit) {
  const auto& s = fit.value;
  Json json = hand_eye_place_json(s);
  json["warnings"] = s.warnings;
  json["board_in_world"] = {{"translation_mm", json_list(s.X_world_board.translation, kMm)},
                            {"rotation_qwxyz", json_quaternion(s.X_world_board.rotation)}};
  json["eye_poses"] = s.pairs;
  json["inliers"] = std::count(fit.inlier.begin(), fit.inlier.end(), true);
  json["rotation_range_deg"] = degrees_from_radians(s.rotation_range);
  json["second_axis_spread_deg"] = degrees_from_radians(s.second_axis_spread);
  json["correlation_time_s"] = s.correlation_time_s;
  json["std_grown_by"] = s.grown_by;
  json["error_length_mm"] = kMm * s.error_length;
  json["method_scatter_mm"] = kMm * s.method_scatter;
  json["condition"] = fit.condition;
  json["std"] = hand_eye_std_json(fit);
  std::vector<std::string> names;
  Eigen::VectorXd scales(13);
  for (const char* part : {"camera", "board"}) {
    for (const char* axis : {"x", "y", "z"})
      scales[static_cast<Eigen::Index>(names.size())] = kDegreesPerRadian,
      names.push_back(fmt::format("{}_turn_{}_deg", part, axis));
    for (const char* axis : {"x", "y", "z"})
      scales[static_cast<Eigen::Index>(names.size())] = kMm,
      names.push_back(fmt::format("{}_{}_mm", part, axis));
  }
  scales[12] = 1.0, names.emplace_back("delay_s");
  json["covariance"] = json_covariance(names, fit.covariance, scales);
  return json;
}

}  // namespace palpate::calibration::findings
