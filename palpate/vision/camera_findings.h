// A camera's lens from views of a board: what calibrate_camera finds, as people and programs read it, and what is to be
// thought of the views. As calibration/findings/findings.h has it: views in memory, no names of files.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "palpate/core/json.h"
#include "palpate/vision/camera.h"

namespace palpate::vision {

struct CameraFindings {
  Estimate<CameraSolution> estimate;
  std::vector<std::string> warnings;
  Json json;
};

// How far the board's first corner was from the camera, m, nearest and farthest view: what another unit of the squares
// changes, and nothing else does.
std::pair<double, double> board_distances(const CameraSolution& lens);

// `warnings`: what was to be said of the views already. A view that repeats an earlier one is left out.
Expected<CameraFindings> find_camera(BoardViews views, const CameraOptions& options = {},
                                     std::vector<std::string> warnings = {});

}  // namespace palpate::vision
