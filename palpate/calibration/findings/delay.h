// The delay between two recordings of one motion: what estimate_motion_delay finds, as people and programs read it.
#pragma once

#include <string>
#include <vector>

#include "palpate/calibration/findings/findings.h"
#include "palpate/calibration/motion_delay.h"

namespace palpate::calibration::findings {

// `warnings`: those of the delay, and what else is to be said.
Json delay_json(const MotionDelay& found, const std::vector<std::string>& warnings);

}  // namespace palpate::calibration::findings
