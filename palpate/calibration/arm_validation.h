// Errors of an arm's calibration on samples it has not seen, and the choice of what to free by them.
//
// Errors in metres. Deterministic. Pure functions, no thread rule.
#pragma once

#include <string>
#include <vector>

#include "palpate/calibration/arm.h"

namespace palpate {

// Held-out mean errors (m): the samples are cut into `regions` parts of the workspace by repeated halving
// across the longest side, and each part is predicted by a calibration that has not seen it.
Expected<std::vector<double>> held_out_by_region(const std::vector<ArmObservation>& samples,
                                                 const ArmModel& model, const ArmOptions& options,
                                                 int regions = 8);

}  // namespace palpate
