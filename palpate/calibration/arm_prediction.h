// How well a calibrated arm knows where its tip is: the covariance at a reading, and a map over the
// workspace.
//
// World, metres, radians; readings psi at rest. From the joint method's covariance C: J C J^T, J the
// derivative of the predicted tip. Pure functions.
#pragma once

#include <vector>

#include "palpate/calibration/arm.h"

namespace palpate::calibration {

// m^2, World.
Matrix3 predicted_covariance(const Estimate<ArmSolution>& estimate, const Eigen::VectorXd& psi);

struct PredictedError {
  Eigen::VectorXd psi;
  Point<World> tip;
  double sd = 0.0;  // m: root of the covariance's trace, the rms distance to the true tip
};

struct PredictedErrorMap {
  std::vector<PredictedError> places;
  double rms = 0.0;  // m, over the places
  PredictedError worst;
};

// Over a grid of the readings that the samples span, the corners included; at most about a thousand places.
PredictedErrorMap predicted_error_map(const Estimate<ArmSolution>& estimate,
                                      const std::vector<device::ArmObservation>& samples);

}  // namespace palpate::calibration
