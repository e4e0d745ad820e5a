// How well an arm's calibration is determined: covariance, condition, and the directions no sample sees.
//
// Internal to this module. SI, radians. Pure functions.
#pragma once

#include "palpate/calibration/internal/arm_setting.h"

namespace palpate::calibration {

// Covariance, condition and unobservable directions at the estimate, from samples whose weight is not zero.
// `allow_field`: see ArmOptions::allow_field.
void add_arm_covariance(Estimate<ArmSolution>& estimate, const ArmSetting& setting,
                        const std::vector<ArmParameter>& parameters, bool allow_field);

}  // namespace palpate::calibration
