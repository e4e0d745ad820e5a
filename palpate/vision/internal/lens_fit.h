// A lens and the board's pose in every view, from corners alone: all of them in one least-squares solve.
//
// For lenses that OpenCV's own solves do not suit. fisheye::calibrate begins from homographies, which boards far from the axis
// do not give: here a view's pose begins from its rays instead, under the equidistant lens (u = f t) that fits all views best.
// The eight coefficients of a rational lens are hardly told apart, and CALIB_RATIONAL_MODEL lets them run along the valley
// where they do the same: here each but the tangential ones is held near 0 by a weak prior (lens_prior()). Frames: Board in
// CameraOptical; metres, pixels. Pure; safe from any thread.
#pragma once

#include <vector>

#include "palpate/vision/camera.h"

namespace palpate::vision {

struct LensFit {
  device::CameraModel lens;
  std::vector<Pose<CameraOptical, Board>> boards;  // one per view
};

// Refused: views none of which has a pose under any lens that is tried; a solve without an end.
Expected<LensFit> fit_fisheye(const std::vector<BoardView>& views, int width, int height);

// From a lens of Brown's on, which fits the views roughly.
Expected<LensFit> fit_rational(const std::vector<BoardView>& views, LensFit start);

// What the solve knows beforehand of each parameter, as information per unit variance of a pixel; 0: nothing. `farthest`: how far
// from the axis, of x/z and y/z, the lens is seen; no term of a real lens's polynomials is much above 1 there.
device::LensParameters lens_prior(device::LensKind kind, double farthest);
double farthest_seen(const BoardView& view, const Pose<CameraOptical, Board>& X);

}  // namespace palpate::vision
