// Where in a recording a tip rested: nobody has to say when it stood in which hollow.
//
// The tip is not known. Pieces in which the marker turns by 20 degrees each give one (the algebraic pivot of pivot.h);
// the one by which most of the recording stands still is taken, and then improved by all rests together, until the
// rests stay the same. A rest is a time in which the tip, so computed, stays in its place while the marker turns.
// Frames as in pivot.h; m, s, rad. Pure. Refused: poses without times or out of their order, no rest at all.
#pragma once

#include <cstddef>
#include <vector>

#include "palpate/calibration/pivot.h"

namespace palpate::calibration {

struct PivotRest {
  std::size_t first = 0, last = 0;  // poses, both included
};

struct PivotRestsOptions {
  double least_s = 1.0;        // shorter is no rest
  double least_turn = 0.1745;  // of the marker in a rest, 10 deg
  double still = 0.4e-3;  // m: the tip's spread within `window_s` of one that rests; more where it is noisier
  double window_s = 0.5;
  double apart = 5e-3;  // m: two rests one after the other without a move between are further apart
};

// In their order; poses of the caller's segments are not looked at.
Expected<std::vector<PivotRest>> find_pivot_rests(const std::vector<PivotPose>& poses,
                                                  const PivotRestsOptions& options = {});

// Numbers the rests 0, 1, ... as segments of the poses; -1 outside.
void put_segments(const std::vector<PivotRest>& rests, std::vector<PivotPose>& poses);

}  // namespace palpate::calibration
