// The truth as the matching calibration would report it: same keys, mm and degrees. For truth.json only.
#pragma once

#include "palpate/core/json.h"
#include "palpate/sim/truth.h"

namespace palpate::sim {

// Offset 1 is 0 and the base is turned instead, as calibrations have it; every tip stays where it is.
Json mm_json(const Vector3& place);
Json arm_truth_json(const Truth& truth, double tracker_delay_s);
Json pivot_truth_json(const Truth& truth, const Vector3& pivot);  // pivot in World
Json hand_eye_truth_json(const Truth& truth, double delay_s);
Json camera_truth_json(const Truth& truth);
Json surface_truth_json(const config::Corners& corners);

}  // namespace palpate::sim
