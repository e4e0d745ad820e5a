// The figures of a verification: what was observed, what the rig's own error is by now, what had been promised. Internal
// to this module. Pure functions, no thread rule.
#pragma once

#include <vector>

#include "palpate/calibration/internal/change_search.h"

namespace palpate::calibration {

// "arm" (mm, of the tip in the poses held), "places" (mm, of what was touched), "picture" (px, of the dots as drawn by
// the tracker's pose of the camera), "tip" (px, of the stylus' tip as drawn, in each picture and pose that has it in the
// picture), "camera delay", "tracker delay" (ms, with their signs). Those that were observed.
std::vector<RigFigure> rig_figures(const RigMisfit& misfit, const RigObservations& observed,
                                   const ChangeFit& found, const VerificationOptions& options);

// Of the root of the mean square over `items` of normal vectors, all in one: mean, covariance. 95 %, both sides; by
// the multiple of a chi-square variable with the sum's mean and variance (Satterthwaite 1946).
struct RmsInterval {
  double rms = 0.0, low = 0.0, high = 0.0, high_one_sided = 0.0;
};
RmsInterval rms_interval(const Eigen::VectorXd& mean, const Eigen::MatrixXd& covariance, Eigen::Index items);

}  // namespace palpate::calibration
