// What the commands of the hand-eye calibration share: two files of poses, read.
#pragma once

#include <string>

#include "palpate/core/expected.h"
#include "palpate/device/pose_file.h"
#include "palpate/rig/rig.h"

namespace palpate::tools::commands {

struct PosePair {
  device::PoseFile hand, eye;
  std::string hash;  // of both
};

// Refused where both files hold the same; `expected` says what the two should hold, in words.
Expected<PosePair> read_pose_pair(const std::string& hand, const std::string& eye,
                                  const std::string& expected);

// What is to be said of a delay between clocks of different origins; empty where it is none.
std::string warning_of_clocks(double delay_s);

// Into the rig, but for such a delay: devices that are used together have one clock. hand time = eye time + delay.
void set_camera_delay(rig::Rig& rig, double delay_s, double std_s, const rig::Provenance& from);

}  // namespace palpate::tools::commands
