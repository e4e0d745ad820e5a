// Calibration of a PHANToM's gimbal: its joint correction, and the turn of the marker on the stylus, from
// gimbal readings and marker orientations of an arm that is calibrated already.
//
// Model (phantom.h): R_world_marker = R_world_base R_base_tip(theta, gain * psi + offset) R_tip_marker.
// Frames: World, Tip, TipMarker; radians. A turn of the last gimbal joint's zero cannot be told from a turn
// of the marker about the stylus: the marker is taken to be mounted without a twist about the stylus' axis
// (no z part in the quaternion), and offset 3 takes what is left; `unobservable` names it. Least squares on
// the rotation error, robust as the arm (Huber, then Tukey), with the same wide prior (gains 0.1, offsets 1
// rad) that keeps directions still which the data do not see. Covariance: gains 3, offsets 3, marker 3 (turn
// on its own side, right perturbation); offset 3 as if the marker had no twist, so the matrix has rank 8. It
// holds what the arm's covariance, where there is one, leaves open. Refused: too few samples with gimbal and
// marker, arms of another kind. Pure function, deterministic.
#pragma once

#include <vector>

#include "palpate/calibration/arm.h"
#include "palpate/rig/rig.h"

namespace palpate::calibration {

struct GimbalSolution {
  device::JointCorrection correction;
  Quaternion R_tip_marker = Quaternion::Identity();
};

Expected<Estimate<GimbalSolution>> calibrate_gimbal(const std::vector<device::ArmObservation>& samples,
                                                    const Estimate<ArmSolution>& arm);

// How the marker is turned away from where it is predicted, rad, in the marker; one per sample with gimbal
// and marker.
std::vector<Vector3> gimbal_errors(const std::vector<device::ArmObservation>& samples, const ArmSolution& arm,
                                   const GimbalSolution& gimbal);

// The gimbal's part of the rig's arm.
inline void put_gimbal_into(rig::ArmCalibration& arm, const GimbalSolution& gimbal) {
  arm.gimbal_gain = gimbal.correction.gain;
  arm.gimbal_offset = gimbal.correction.offset;
  arm.R_tip_marker = gimbal.R_tip_marker;
}

}  // namespace palpate::calibration
