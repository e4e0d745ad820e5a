// Whether the two streams of a hand-eye calibration are read as they were meant: poses of the camera in the board's frame,
// not the board's in the camera's; lengths of both in one unit.
//
// Solvers of one picture (OpenCV's solvePnP, most ROS packages) give the board in the camera. Turned round, such poses fit by
// a multiple; as they stand, they solve the equation badly or not at all, and more motion does not help. Lengths in another
// unit show in the factor that brings the eye's places to the hand's, linear in the equation once its rotations are known.
// Pure functions; places in m.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "palpate/calibration/internal/hand_eye_start.h"

namespace palpate::calibration {

// What is wrong, in words, where `round`, a start with the eye's poses turned round, fits far better than `start`; else empty.
std::string doubt_of_direction(const HandEyeStart& start, const HandEyeStart& round);

// The poses with each quaternion's four numbers in the other order (device::in_other_order()). Alone the places tell this
// mistake from poses turned round.
std::vector<device::StampedPose> reordered(std::vector<device::StampedPose> poses, bool told_scalar_first);

// What is wrong, in words, where `other`, a start with the quaternions of `whose` poses reordered, fits far better than
// `start` and than `round`; else empty.
std::string doubt_of_order(const HandEyeStart& start, const HandEyeStart& round, const HandEyeStart& other,
                           std::string_view whose, bool told_scalar_first);

// Whether a start is so good that nobody need ask how else the poses may be read.
bool is_good(const HandEyeStart& start);

struct LengthRatio {
  double ratio = 1.0, std = 1e300;  // the eye's places fit this many times as long
  // What is left over, as a share of what they then tell of the motion. Streams that do not belong together in time leave
  // most of it, and a ratio that is too small.
  double left_over = 1.0;
};
LengthRatio length_ratio(const std::vector<device::StampedPose>& hand,
                         const std::vector<device::StampedPose>& eye, const HandEyeState& at,
                         double max_gap_s);

// What is wrong, in words, where the eye's lengths are in another unit than the hand's; else empty.
std::string doubt_of_unit(const LengthRatio& found);

}  // namespace palpate::calibration
