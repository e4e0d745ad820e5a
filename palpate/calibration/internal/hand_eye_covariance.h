// How well a hand-eye calibration is known: white noise by the sandwich estimate, and errors that several
// poses share in two ways, of which the larger counts.
//
// In time: Bartlett weights over the residuals' correlation time (Newey & West 1987). With the pose: a smooth
// field over the hand's poses (smooth_error.h), for each whitened residual component; it also answers for the
// part of a tracker's bias that changes so evenly with the pose that the camera's place follows it. The delay
// carries the clocks' own offset besides, which no residual shows. Order of
// the covariance: hand_eye_problem.h. Pure function.
#pragma once

#include "palpate/calibration/internal/hand_eye_problem.h"

namespace palpate::calibration {

struct HandEyeCovariance {
  HandEyeNormal total;
  double condition = 0.0;           // of the scaled normal equations
  double correlation_time_s = 0.0;  // how long residuals stay alike
  double grown_by = 1.0;            // factor on the deviations against white noise alone, rms over unknowns
  double field_length = 0.0;        // m, correlation length of the errors that change with the pose
};

HandEyeCovariance hand_eye_covariance(const HandEyeProblem& problem, const HandEyeState& x);

}  // namespace palpate::calibration
