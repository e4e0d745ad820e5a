// A tip in its marker's frame: what calibrate_pivot finds in a recording, and what is to be thought of it.
#pragma once

#include <string>
#include <vector>

#include "palpate/calibration/findings/findings.h"
#include "palpate/calibration/pivot.h"

namespace palpate::calibration::findings {

// PivotCalibrationOptions::motion_strain where a calibrated arm measured the motion: its gains are known to a tenth of a
// percent, what is left is flexing.
inline constexpr double kStrainOfCalibratedArm = 0.005;

struct PivotTask {
  std::vector<PivotPose> poses;
  std::vector<std::string> segments;  // labels of the poses' segments; empty: there is one
  bool find_rests = false;  // the segments are found by themselves (pivot_rests.h), and numbered from 1
  PivotCalibrationOptions how = {.shared_errors = true};
};

struct PivotFindings {
  Estimate<PivotSolution> estimate;
  std::vector<std::string> segments;
  Json json;
};

// Poses that all have a time are sorted by it.
Expected<PivotFindings> find_pivot(PivotTask task);

}  // namespace palpate::calibration::findings
