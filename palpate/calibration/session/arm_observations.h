// Between recordings, the arm's calibration and the rig. World frame, SI. Pure.
#pragma once

#include <vector>

#include "palpate/calibration/arm.h"
#include "palpate/calibration/session/procedures.h"
#include "palpate/rig/rig.h"

namespace palpate::calibration::session {

// The recording as calibrate_arm wants it; the tip's covariance as the tracker believes it for a tip at
// `tip`.
std::vector<device::ArmObservation> arm_observations(const std::vector<TrackedPose>& poses,
                                                     const Vector3& tip);

// The covariance of an arm's result in the order of rig::covariance_order, zero where fixed.
Eigen::MatrixXd rig_covariance(const Estimate<ArmSolution>& estimate);

// The arm's result as the rig keeps it; of a PHANToM without its gimbal (put_gimbal_into).
rig::ArmCalibration rig_arm(const Estimate<ArmSolution>& estimate);

}  // namespace palpate::calibration::session
