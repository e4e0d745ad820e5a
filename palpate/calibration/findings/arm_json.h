// An arm's findings as JSON; all but `ArmFindings::json` is read.
#pragma once

#include "palpate/calibration/findings/arm.h"

namespace palpate::calibration::findings {

Json arm_json(const ArmFindings& found);

// How far the gimbal leaves the stylus off its marker, rms over the samples that its fit went by.
double gimbal_rms_deg(const Estimate<GimbalSolution>& gimbal, const ArmSolution& arm,
                      const std::vector<device::ArmObservation>& samples);

}  // namespace palpate::calibration::findings
