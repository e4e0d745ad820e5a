// What a calibration says to whoever asked for it: its result as JSON with units in the keys, standard deviations,
// covariance and warnings. The command line writes it to files, the Python package hands it on; both therefore say the
// same, to the last bit.
//
// The headers beside this one have a function for each calibration. It takes measurements in memory (SI, radians), leaves
// out repeats, calls the calibration and judges what came out. A refusal does not name where the data came from, nor does
// the JSON (`data`): the caller adds it. Pure functions, no thread rule.
#pragma once

#include "palpate/core/json.h"
#include "palpate/core/units.h"
#include "palpate/math/json_values.h"

namespace palpate::calibration::findings {

inline constexpr double kMm = kMillimetresPerMetre;  // what people read is in millimetres

}  // namespace palpate::calibration::findings
