// Whether a recording's motion can carry a hand-eye calibration: how far and about how many axes it turned,
// how many poses really differ, and whether methods that weigh the same poses differently agree.
//
// Closed forms over pairs of at most 40 poses: rotation by Park & Martin (1994) and by Tsai & Lenz (1989),
// each with the linear translation (R_hand - 1) x = X_rotation eye - hand, and Daniilidis' dual quaternions
// (1999). On good motion they differ by the noise; on poor motion by much more, each following another weak
// direction. Radians, metres. Pure functions.
#pragma once

#include <string>
#include <vector>

#include "palpate/calibration/internal/hand_eye_problem.h"

namespace palpate::calibration {

struct HandEyeMotion {
  Vector3 spread = Vector3::Zero();  // rad, rms turn about the three main axes, largest first
  double range = 0.0;                // rad, largest angle between two poses
  int distinct = 0;  // poses that differ from all others counted by 2 deg or more, at most 100 are counted
};
HandEyeMotion hand_eye_motion(const std::vector<HandAt>& hand);

struct HandEyeClosedForm {
  std::string name;
  Quaternion rotation = Quaternion::Identity();  // of X
  Vector3 translation = Vector3::Zero();         // of X, m
};
// Those that gave an answer; hand[i] belongs to eye[i].
std::vector<HandEyeClosedForm> hand_eye_closed_forms(const std::vector<HandAt>& hand,
                                                     const std::vector<device::StampedPose>& eye);

}  // namespace palpate::calibration
