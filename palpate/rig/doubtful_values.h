// Values of a rig that can be read and cannot be right: a slip in a file written by hand, or a calibration that data of
// too few places carried beyond them.
//
// Judged are the lens, by what a pinhole with five coefficients holds for, and the tip in its marker, by a stylus's
// reach and by what pivot and arm each say of it, delays by how long they last. A place that is some millimetres off
// looks like any other: `palpate verify` finds those. Pure function.
#pragma once

#include <string>
#include <vector>

#include "palpate/rig/rig.h"

namespace palpate::rig {

// No stylus reaches farther from its marker.
inline constexpr double kStylusReach = 0.6;  // m
// A tip nearer to its marker's origin: metres stand where millimetres are said.
inline constexpr double kNearestTip = 0.001;  // m

struct DoubtfulValue {
  std::string part;  // "camera", as missing_parts names it
  std::string what;  // what cannot be right, and what to do
};
std::vector<DoubtfulValue> doubtful_values(const Rig& rig);

}  // namespace palpate::rig
