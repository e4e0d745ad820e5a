// A wide lens and the board's pose in every view, from corners alone: all of them in one least-squares solve.
//
// OpenCV's fisheye::calibrate begins from homographies, which boards far from the axis do not give. Here a view's pose
// begins from its rays instead, under the equidistant lens (u = f t) that fits all views best. Frames: Board in
// CameraOptical; metres, pixels. Pure; safe from any thread.
#pragma once

#include <vector>

#include "palpate/vision/camera.h"

namespace palpate::vision {

struct FisheyeFit {
  device::CameraModel lens;
  std::vector<Pose<CameraOptical, Board>> boards;  // one per view
};

// Refused: views none of which has a pose under any lens that is tried; a solve without an end.
Expected<FisheyeFit> fit_fisheye(const std::vector<BoardView>& views, int width, int height);

}  // namespace palpate::vision
