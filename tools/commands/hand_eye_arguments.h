// What `calibrate hand-eye` is asked for, and its two ways: from poses of the camera, and from the board's corners.
#pragma once

#include <string>

#include "palpate/core/expected.h"
#include "tools/commands/board_options.h"
#include "tools/commands/result_output.h"

namespace palpate::tools::commands {

struct HandEyeArguments {
  ResultOptions result;
  std::string camera = "left";  // of two: the one whose result the rig gets
  std::string hand, eye;
  bool estimate_delay = false;
  double delay_s = 0.0;
  // From corners: in place of `eye`.
  BoardOptions board;
  std::string stamps, lens, lens_model;
  double tracker_sd_mm = 0.0, tracker_sd_deg = 0.0;  // 0: told by the residuals
};

Expected<void> run_hand_eye_pixels(const HandEyeArguments& options);

}  // namespace palpate::tools::commands
