// An arm's findings as JSON; all but `ArmFindings::json` is read.
#pragma once

#include "palpate/calibration/findings/arm.h"

namespace palpate::calibration::findings {

Json arm_json(const ArmFindings& found);

}  // namespace palpate::calibration::findings
