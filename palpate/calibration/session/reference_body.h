// Poses of a marker seen from a reference body that the tracker sees as well: the tracker may be moved while it is recorded.
//
// X_reference_marker = X_tracker_reference^-1 X_tracker_marker, both at the marker's time; the reference is interpolated between its
// neighbours where it has other stamps. The covariance is propagated to first order for independent errors of the two (rotation then
// translation, left perturbation, axes of the reference body): with A the reference, B the marker, d = t_B - t_A,
//   dphi = R_A^T (phi_B - phi_A),   dt = R_A^T (tau_B - tau_A + d x phi_A).
// Systematic parts add: where the two are near each other they cancel in part, so this overstates them. m, rad. Pure.
#pragma once

#include <vector>

#include "palpate/calibration/session/recorder.h"

namespace palpate::calibration::session {

// One for each of `poses`, at its time; not seen where the marker or the reference was not. Both as of DeviceStreams::marker_poses().
std::vector<TrackedPose> in_reference(const std::vector<TrackedPose>& poses,
                                      const std::vector<TrackedPose>& reference);

}  // namespace palpate::calibration::session
