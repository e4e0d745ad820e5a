// Recordings as the CSV files that `palpate calibrate` reads: mm, degrees, seconds of host time.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "palpate/calibration/session/calibration_session.h"
#include "palpate/calibration/session/holds.h"
#include "palpate/calibration/session/procedures.h"
#include "palpate/device/arm_model.h"

namespace palpate::calibration::session {

// time_s, marker pose, and the arm's readings beside it where `with_arm`. `segments`: for each pose the number of the rest it belongs
// to, 0 for none, in a column `segment`; empty: no such column. `model`: of the arm, whose readings are degrees of its joints or, where
// it states its place, mm.
std::string pivot_csv(const std::vector<TrackedPose>& poses, bool with_arm,
                      const std::vector<int>& segments = {}, const device::ArmModel& model = {});
// time_s, marker pose, and the upper triangle of its covariance: noise, rotation (rx, ry, rz, rad) then translation, as of
// TrackerSample, and the systematic part of the translation (sys_*).
std::string marker_csv(const std::vector<TrackedPose>& poses);
// The arm's readings as for pivot_csv(), marker pose, and the covariance of the measured tip, which lies at `tip` in the
// marker as far as anybody knows.
std::string arm_csv(const std::vector<TrackedPose>& poses, const Vector3& tip,
                    const device::ArmModel& model = {});
// label, x_mm, y_mm, z_mm
std::string points_csv(const std::vector<TouchedPoint>& touches);

// label, x_mm, y_mm, z_mm, std_*_mm (of single poses about the mean), frames, time_s and seconds of the hold, cov_*_mm2 (of the mean, as
// the tracker believes). A label for each.
std::string touches_csv(const std::vector<HeldTouch>& touches, const std::vector<std::string>& labels);

// image, corner, where it lies on the board in squares of `square` m, where it was seen in px
std::string corners_csv(const std::vector<vision::BoardView>& views,
                        double square = vision::BoardShape{}.square);

// The camera at the board in one picture.
struct BoardSight {
  double time_s = 0.0;  // host time of mid-exposure
  std::string image;
  Pose<Board, CameraOptical> pose;
  double rms_px = 0.0;
};
// time_s, pose, rms_px, image
std::string sights_csv(const std::vector<BoardSight>& sights);

template <typename A, typename B>
std::string poses_csv(const std::vector<TimedPose<A, B>>& poses);

// All that a session has recorded so far, by the names that recordings give their tables; parts that are empty are left out. `tip`
// as for arm_csv().
std::vector<std::pair<std::string, std::string>> session_tables(const CalibrationRecordings& recordings,
                                                                const Vector3& tip);

}  // namespace palpate::calibration::session
