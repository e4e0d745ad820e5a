// A camera's lens from views of a board: what calibrate_camera finds, as people and programs read it, and what is to be
// thought of the views. As calibration/findings/findings.h has it: views in memory, no names of files.
#pragma once

#include <string>
#include <vector>

#include "palpate/core/json.h"
#include "palpate/vision/camera.h"

namespace palpate::vision {

struct CameraFindings {
  Estimate<CameraSolution> estimate;
  std::vector<std::string> warnings;
  Json json;
};

// `warnings`: what was to be said of the views already. A view that repeats an earlier one is left out.
Expected<CameraFindings> find_camera(BoardViews views, const CameraOptions& options = {},
                                     std::vector<std::string> warnings = {});

}  // namespace palpate::vision
