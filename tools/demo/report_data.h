// What the demo's page draws and lists, computed from a play's folder: numbers under names, no words. Each function
// gives an object of parts; a part whose files or columns are missing is left out. Lists are in the units that their
// names or those of their columns state; not a number is a gap. Pure. Internal to this module.
#pragma once

#include <vector>

#include "palpate/core/json.h"
#include "palpate/figures/play_folder.h"
#include "palpate/figures/plot.h"

namespace palpate::tools::demo {

// arm_shares (by method: mm, share of poses), arm_strokes (by method: mm, from a place to ten times its error),
// guidance, pivot (mm), lens (rows of name, estimated, true).
Json calibration_data(const figures::PlayFolder& play);

// overlay, overlay_shares, late and answers (counts and shares of the frames, by kind), surfaces (m).
Json play_data(const figures::PlayFolder& play);

// round_trips, jitter, latency, clock_difference, clock_error, realtime_overlay, late_answers, loop_faults, trips; and
// what tells that there was nothing to draw: no_late_answers, no_loop_faults.
Json realtime_data(const figures::PlayFolder& play);

// events (in the order of time), phases, timeline, clocks, loops of a run on two hosts whose cable was pulled; empty without.
Json network_data(const figures::PlayFolder& play);

// {"x": ..., "y": ...}
inline Json xy(const std::vector<double>& x, const std::vector<double>& y) { return {{"x", x}, {"y", y}}; }
inline Json xy(const figures::Series& series) { return xy(series.x, series.y); }

}  // namespace palpate::tools::demo
