// Pivots by the sphere that the marker's origin moves on: a centre for each segment and one radius.
//
// Least squares on |p_i - motion_i - c_s| - r, from the linear (algebraic) sphere. Metres; pure function.
// Refused: origins in a plane, or too few; a search that does not settle.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "palpate/calibration/internal/pivot_problem.h"
#include "palpate/core/expected.h"

namespace palpate::calibration {

struct PivotSphere {
  std::vector<Vector3> centres;
  double radius = 0.0;
  Eigen::MatrixXd normal;  // of centres 3S, then radius
};

Expected<PivotSphere> fit_spheres(const PivotData& data);

}  // namespace palpate::calibration
