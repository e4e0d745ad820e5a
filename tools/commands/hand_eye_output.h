// What the commands of the hand-eye calibration share: two files of poses read, and the numbers found.
#pragma once

#include <string>

#include "palpate/calibration/hand_eye.h"
#include "palpate/core/expected.h"
#include "palpate/core/json.h"
#include "palpate/device/pose_file.h"

namespace palpate::tools::commands {

struct PosePair {
  device::PoseFile hand, eye;
  std::string hash;  // of both
};

// Refused where both files hold the same; `expected` says what the two should hold, in words.
Expected<PosePair> read_pose_pair(const std::string& hand, const std::string& eye,
                                  const std::string& expected);

// Place, turn, delay and residuals.
Json hand_eye_json(const calibration::HandEyeSolution& found);
// Standard deviations of these.
Json hand_eye_std_json(const Estimate<calibration::HandEyeSolution>& fit);

}  // namespace palpate::tools::commands
