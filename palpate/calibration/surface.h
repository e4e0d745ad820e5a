// A real rectangle (table, wall) from the points a tracked pointer touched.
//
// Frames: World; Rectangle: origin at corner 1, x to corner 2, y to corner 4, z = x cross y out of the
// surface when the corners were touched counter-clockwise as seen from outside. Metres. Pure functions. Fit:
// pose and the two sides by Gauss-Newton, all touched corners weighing the same; points that are no corner
// count with their distance from the plane. Residuals: touched - fitted corner, or the normal distance as a
// vector. Covariance order: rotation 3 (rad, World axes), corner 1 (3, m), width, height (m). Refused: fewer
// than four corners, corners on a line, touched crosswise, not planar or not a rectangle (beyond
// `tolerance`), numbers that are not finite.
#pragma once

#include <optional>
#include <vector>

#include "palpate/core/expected.h"
#include "palpate/estimation/estimate.h"
#include "palpate/geometry/pose.h"

namespace palpate {

struct TouchedPoint {
  Point<World> place;
  int corner = 0;  // 1 to 4 in touching order; 0 = somewhere on the surface
};

struct RectangleFit {
  Pose<World, Rectangle> X_world_rectangle;
  double width = 0.0, height = 0.0;  // m, corner 1 to 2 and 1 to 4
  // 1 to 4
  Point<World> corner(int number) const;
};

struct RectangleOptions {
  double tolerance = 0.02;         // largest misfit of a corner, as a part of the diagonal
  double least_tolerance = 0.003;  // m, ten times what a hand misses a corner by
  // m per axis, by how much a touch is known to miss; the covariance then rests on it as well as on these few
  // residuals (it counts as much as eight of them). 0: on the residuals alone.
  double touch_sd = 0.0;
};

// Without corner numbers (all 0) the first four points are the corners in order.
Expected<Estimate<RectangleFit>> fit_rectangle(std::vector<TouchedPoint> points,
                                               const RectangleOptions& options = {});

}  // namespace palpate
