// Recordings as the CSV files that `palpate calibrate` reads: mm, degrees, seconds of host time.
#pragma once

#include <string>
#include <vector>

#include "palpate/calibration/session/procedures.h"

namespace palpate::calibration::session {

// time_s, marker pose, and the arm's readings beside it where `with_arm`.
std::string pivot_csv(const std::vector<TrackedPose>& poses, bool with_arm);
// Joint and gimbal readings, marker pose, and the covariance of the measured tip, which lies at `tip` in the
// marker as far as anybody knows.
std::string arm_csv(const std::vector<TrackedPose>& poses, const Vector3& tip);
// label, x_mm, y_mm, z_mm
std::string points_csv(const std::vector<TouchedPoint>& touches);

template <typename A, typename B>
std::string poses_csv(const std::vector<TimedPose<A, B>>& poses);

}  // namespace palpate::calibration::session
