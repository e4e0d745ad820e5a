#include "palpate/sim/truth_json.h"

#include "palpate/core/units.h"

namespace palpate::sim {
namespace {

Json list(const Vector3& v, double unit = 1.0) { return {v.x() * unit, v.y() * unit, v.z() * unit}; }
Json deg(const Vector3& v) { return list(v, kDegreesPerRadian); }
Json wxyz(const Quaternion& q) { return {q.w(), q.x(), q.y(), q.z()}; }

}  // namespace

Json mm_json(const Vector3& place) { return list(place, kMillimetresPerMetre); }

Json arm_truth_json(const Truth& truth, double tracker_delay_s) {
  const auto arm = arm_with_first_offset_zero(truth);
  Json json;
  json["gains"] = list(arm.joints.gain);
  json["offsets_deg"] = deg(arm.joints.offset);
  json["lengths_mm"] = {mm_from_metres(arm.lengths.l1), mm_from_metres(arm.lengths.l2)};
  json["tip_mm"] = mm_json(truth.tip_in_marker);
  // A delta's base turns with nothing else.
  const auto& base = truth.delta ? truth.X_world_base : arm.X_world_base;
  json["base"] = {{"translation_mm", mm_json(base.translation)}, {"rotation_qwxyz", wxyz(base.rotation)}};
  json["gimbal_gains"] = list(arm.gimbal.gain);
  json["gimbal_offsets_deg"] = deg(arm.gimbal.offset);
  json["marker_on_stylus_qwxyz"] = wxyz(truth.X_tip_marker.rotation);
  json["delay_s"] = tracker_delay_s;
  if (truth.delta) {
    json["chains"] = Json::array();
    for (const auto& chain : truth.delta->chains())
      json["chains"].push_back({{"azimuth_deg", degrees_from_radians(chain.azimuth)},
                                {"offset_mm", mm_from_metres(chain.offset)},
                                {"upper_mm", mm_from_metres(chain.upper)},
                                {"lower_mm", mm_from_metres(chain.lower)},
                                {"zero_deg", degrees_from_radians(chain.zero)}});
  }
  return json;
}

Json pivot_truth_json(const Truth& truth, const Vector3& pivot) {
  Json json;
  json["tip_mm"] = mm_json(truth.tip_in_marker);
  json["pivot_mm"] = mm_json(pivot);
  return json;
}

Json hand_eye_truth_json(const Truth& truth, double delay_s) {
  Json json;
  json["translation_mm"] = mm_json(truth.X_marker_camera.translation);
  json["rotation_qwxyz"] = wxyz(truth.X_marker_camera.rotation);
  json["delay_s"] = delay_s;
  return json;
}

Json camera_truth_json(const Truth& truth) {
  Json json;
  json["fx"] = truth.lens.fx;
  json["fy"] = truth.lens.fy;
  json["cx"] = truth.lens.cx;
  json["cy"] = truth.lens.cy;
  json["lens"] = device::lens_word(truth.lens.kind);
  const auto coefficients = truth.lens.coefficients();
  json["distortion"] = std::vector<double>(coefficients.begin(), coefficients.end());
  return json;
}

Json surface_truth_json(const config::Corners& corners) {
  Json json;
  json["corners_mm"] = Json::array();
  for (const auto& corner : corners) json["corners_mm"].push_back(mm_json(corner));
  json["width_mm"] = mm_from_metres((corners[1] - corners[0]).norm());
  json["height_mm"] = mm_from_metres((corners[3] - corners[0]).norm());
  return json;
}

}  // namespace palpate::sim
