// Whether the two streams of a hand-eye calibration are what they are said to be: the hand's the marker in the
// tracker, the eye's the camera at its board.
//
// Exchanged streams and poses turned round solve the equation with another X and Z and residuals as small. What tells
// is that a camera looks at its board: the board's origin lies near its optical axis. 95 % of a real camera's poses
// (data/ethz_handeye_primesense1) have it within 34 deg, 95 % of the simulated head's within 27 deg; a marker's +z
// axis points anywhere. Where it happens to point at the tracker's origin nothing is known. Pure function.
#pragma once

#include <string>
#include <vector>

#include "palpate/device/pose_file.h"

namespace palpate::calibration {

// What is doubted, in words; empty: nothing.
std::string doubt_of_roles(const std::vector<device::StampedPose>& hand,
                           const std::vector<device::StampedPose>& eye);

}  // namespace palpate::calibration
