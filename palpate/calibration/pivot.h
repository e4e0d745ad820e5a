// Pivot calibration: where a tip sits in its marker's frame, from poses taken while the tip rested at fixed
// points.
//
// Frames: a pose (R_i, p_i) maps marker coordinates to the tracker's; the tip t is constant in the marker,
// the pivot c_s constant in the tracker's frame during segment s: R_i t + p_i = c_s. Metres. Pure functions.
// Methods:
//  - algebraic: the linear least squares of that equation over all segments at once (Tuceryan et al. 1995);
//  - robust: the same, iteratively reweighted (Huber, then Tukey; scale from the median), outliers named;
//  - sphere: a sphere through the marker's origins (shared radius), the tip from its centres; what the 2006
//  paper does.
// Where the tip itself moved a little and the arm measured how (`motion`), c_s + A * (motion_i - their mean)
// takes the pivot's place, A a rotation found with the rest. Covariance order: tip 3, then 3 per pivot (m^2).
// It grows with the correlation of neighbouring residuals (`correlation`, 1 = white): a tracker's bias makes
// samples tell less than their number. With `shared_errors`: pivot_covariance.h, and never less than the tips
// of three and more segments scatter. Refused: fewer than 4 poses, too little rotation or rotation about one
// axis only, numbers that are not finite, poses that agree with no resting tip (residual above 10 mm), a tip
// more than 10 m away.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "palpate/core/expected.h"
#include "palpate/math/estimate.h"
#include "palpate/math/so3.h"

namespace palpate::calibration {

struct PivotPose {
  Quaternion rotation = Quaternion::Identity();
  Vector3 translation = Vector3::Zero();  // m
  int segment = 0;                        // 0, 1, ...; negative = not used
  std::optional<Vector3> motion;          // m, the tip as the arm saw it, ArmBase
  std::optional<double> time_s;           // when; with all of them, a delay of the motion is estimated
};

enum class PivotMethod { algebraic, sphere, robust };

struct PivotCalibrationOptions {
  PivotMethod method = PivotMethod::algebraic;
  std::optional<Vector3> given_tip;  // m; then only the pivots are estimated
  bool with_motion = false;          // subtract the tip's own motion; every used pose must have it
  // The covariance counts errors that samples share (pivot_covariance.h); else only the residuals'
  // autocorrelation widens it, which takes no time: for studies of thousands. Not for the sphere.
  bool shared_errors = false;
  std::uint64_t seed = 1;           // of the bootstrap
  double motion_strain = 0.02;      // what is unknown of the arm's motion: 2 % for nominal joint gains
  double needed_rotation = 0.1745;  // rad: largest angle between two poses of a segment, 10 deg
  double needed_tilt = 0.0175;  // rad: rms swing about the weakest axis, 1 deg (ten times a tracker's noise)
};

struct PivotSegment {
  Vector3 pivot = Vector3::Zero();        // m
  std::optional<Vector3> own_tip;         // m, from this segment alone; none where it turns too little
  double rms = 0.0;                       // m, per component, with the common tip
  double own_rms = 0.0;                   // m, with its own tip
  std::optional<Matrix3> own_covariance;  // m^2, of own_tip; with shared_errors only
  int poses = 0;
};

struct PivotSolution {
  Vector3 tip = Vector3::Zero();  // m, marker frame
  std::vector<PivotSegment> segments;
  double rotation_range = 0.0;            // rad, largest angle between two poses of one segment
  double correlation = 1.0;               // integrated autocorrelation of the residuals
  Matrix3 tip_scatter = Matrix3::Zero();  // m^2, of the segments' own tips; zero with fewer than three
  Quaternion R_world_arm = Quaternion::Identity();  // A, with motion only
  double delay = 0.0;  // s, the arm's readings at time + delay belong to the pose; with motion and times only
  double tip_motion = 0.0;  // m, rms about its mean, where the poses carry it, subtracted or not
  // m: with shared_errors, where the poses carry the tip's motion but it was not to be subtracted: by how
  // much the tip would lie elsewhere if it were. The covariance then contains it.
  std::optional<Vector3> tip_shift;
  Vector3 bootstrap_std = Vector3::Zero();  // m, of the tip; with shared_errors only
  int bootstrap_block = 0;                  // poses
  double field_sd = 0.0;                    // m, per component, of errors that change with the pose
};

// Residuals are c_s - (R_i t + p_i) (with the sphere method too), one per pose with segment >= 0, in order.
Expected<Estimate<PivotSolution>> calibrate_pivot(const std::vector<PivotPose>& poses,
                                                  const PivotCalibrationOptions& options = {});

}  // namespace palpate::calibration
