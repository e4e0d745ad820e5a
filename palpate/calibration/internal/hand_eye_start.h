// A start for hand-eye calibration at a supposed delay: rotation after Park & Martin (1994), by Kabsch over
// relative rotations; the board's rotation as a weighted mean of quaternions (Markley 2007); both
// translations linearly; all reweighted against blunders; then a short solve on at most 300 poses. Pure
// function.
#pragma once

#include "palpate/calibration/internal/hand_eye_problem.h"

namespace palpate::calibration {

struct HandEyeStart {
  HandEyeState state;
  double quality = 1e300;  // log of median rotation times median translation residual: needs no scale
};

HandEyeStart hand_eye_start(const std::vector<device::StampedPose>& hand,
                            const std::vector<device::StampedPose>& eye, double delay, double max_gap_s,
                            bool free_delay);

}  // namespace palpate::calibration
