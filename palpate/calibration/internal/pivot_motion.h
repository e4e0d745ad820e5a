// Pivot calibration of a tip that gives way while an arm's encoders watch it (--with-arm): the tip's own
// motion, turned into the tracker's frame, is taken out of the marker's. Metres, seconds; pure functions.
#pragma once

#include <vector>

#include "palpate/calibration/internal/pivot_problem.h"

namespace palpate::calibration {

// The arm's part, in its base: motion about each segment's mean, and how fast it changes (zero where times
// are unknown).
struct TipMotion {
  std::vector<Vector3> centred, rate;
};

TipMotion tip_motion(const PivotData& data, const std::vector<Vector3>& motion,
                     const std::vector<double>& time_s);

// Tip, the rotation that carries the arm's motion into the tracker's frame, and by how much the tracker's
// stamps are late against the arm's, together (least squares on columns from which the segments' means are
// taken). The delay is held near zero as strongly as kDelay says: a slow swing hardly shows it.
Vector3 solve_with_motion(PivotData& data, const TipMotion& arm, Quaternion& turn, double& delay);

}  // namespace palpate::calibration
