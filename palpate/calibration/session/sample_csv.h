// Recordings as the CSV files that `palpate calibrate` reads: mm, degrees, seconds of host time.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "palpate/calibration/session/calibration_session.h"
#include "palpate/calibration/session/procedures.h"

namespace palpate::calibration::session {

// time_s, marker pose, and the arm's readings beside it where `with_arm`.
std::string pivot_csv(const std::vector<TrackedPose>& poses, bool with_arm);
// Joint and gimbal readings, marker pose, and the covariance of the measured tip, which lies at `tip` in the
// marker as far as anybody knows.
std::string arm_csv(const std::vector<TrackedPose>& poses, const Vector3& tip);
// label, x_mm, y_mm, z_mm
std::string points_csv(const std::vector<TouchedPoint>& touches);

// image, corner, where it lies on the board in squares, where it was seen in px
std::string corners_csv(const std::vector<vision::BoardView>& views);

template <typename A, typename B>
std::string poses_csv(const std::vector<TimedPose<A, B>>& poses);

// All that a session has recorded so far, by the names that recordings give their tables; parts that are empty are left out. `tip`
// as for arm_csv().
std::vector<std::pair<std::string, std::string>> session_tables(const CalibrationRecordings& recordings,
                                                                const Vector3& tip);

}  // namespace palpate::calibration::session
