// What the commands of the hand-eye calibration share: two files of poses, read.
#pragma once

#include <string>

#include "palpate/core/expected.h"
#include "palpate/device/pose_file.h"

namespace palpate::tools::commands {

struct PosePair {
  device::PoseFile hand, eye;
  std::string hash;  // of both
};

// Refused where both files hold the same; `expected` says what the two should hold, in words.
Expected<PosePair> read_pose_pair(const std::string& hand, const std::string& eye,
                                  const std::string& expected);

}  // namespace palpate::tools::commands
