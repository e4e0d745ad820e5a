// Between recordings, the arm's calibration and the rig. World frame, SI. Pure.
#pragma once

#include <vector>

#include "palpate/acquisition/procedures.h"
#include "palpate/calibration/arm.h"
#include "palpate/model/rig.h"

namespace palpate {

// The recording as calibrate_arm wants it; the tip's covariance as the tracker believes it for a tip at
// `tip`.
std::vector<ArmObservation> arm_observations(const std::vector<TrackedPose>& poses, const Vector3& tip);

// The arm's result as the rig keeps it.
ArmCalibration rig_arm(const Estimate<ArmSolution>& estimate);

}  // namespace palpate
