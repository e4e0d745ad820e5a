// A camera in its marker: what calibrate_hand_eye finds, as people and programs read it.
#pragma once

#include "palpate/calibration/findings/findings.h"
#include "palpate/calibration/hand_eye.h"

namespace palpate::calibration::findings {

// Poses without times belong together row by row, their times are the rows' numbers: HandEyeOptions::max_hand_gap_s.
inline constexpr double kRowByRow = 1.5;

// All that is found.
Json hand_eye_json(const Estimate<HandEyeSolution>& fit);

// Parts of it: place, turn, delay and residuals; standard deviations of these.
Json hand_eye_place_json(const HandEyeSolution& found);
Json hand_eye_std_json(const Estimate<HandEyeSolution>& fit);

}  // namespace palpate::calibration::findings
