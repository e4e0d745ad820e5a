// By how much the clocks of two streams of poses differ, and how the two bodies are turned against each
// other, from the angular velocity alone: the coarse start of a hand-eye calibration.
//
// Both bodies are one rigid piece, so that in their own axes w_hand(t + delay) = R w_eye(t). For every lag at
// which the streams overlap, the best rotation R (Wahba 1965, solved by Kabsch's singular values) gives a
// correlation r = tr(R^T sum w_hand w_eye^T) / (|w_hand| |w_eye|); a lag is judged by atanh(r) sqrt(n), so
// that a short lucky overlap does not beat a long good one. Unlike a correlation of speeds it knows
// directions, so that the regular swinging of a head does not fit half a period off. Radians, seconds; poses
// sorted by time, times strictly increasing. Pure function.
#pragma once

#include <vector>

#include "palpate/device/pose_file.h"

namespace palpate::calibration {

struct DelayCandidate {
  double delay_s = 0.0;  // hand time = eye time + delay
  double correlation = 0.0;
  double score = 0.0;
  double overlap_s = 0.0;
  Quaternion R_hand_eye = Quaternion::Identity();
};

// Local maxima, best first, at most eight; empty where the streams never turn together.
std::vector<DelayCandidate> delay_candidates(const std::vector<device::StampedPose>& hand,
                                             const std::vector<device::StampedPose>& eye);

}  // namespace palpate::calibration
