// A real rectangle (table, wall) from the points a tracked pointer touched.
//
// Frames: World; Rectangle: origin at corner 1, x to corner 2, y to corner 4, z = x cross y out of the
// surface when the corners were touched counter-clockwise as seen from outside. Metres. Pure functions. Fit:
// pose and the two sides by least squares, all touched corners weighing the same; points that are no corner
// count with their distance from the plane. Residuals: touched - fitted corner, or the normal distance as a
// vector. Covariance order: rotation 3 (rad, World axes), corner 1 (3, m), width, height (m); it has two
// parts, the hand's, whose size is learned from the touches, and the tracker's, which touches of one corner
// share. The hand's part is a variance component (Foerstner 1979): what touches of one corner differ by is
// the hand alone, what corners miss the rectangle by is both, and counts by the hand's share in it. Refused:
// fewer than four corners, corners on a line, touched crosswise, not planar or not a rectangle (beyond
// `tolerance`), numbers that are not finite.
#pragma once

#include <string>
#include <vector>

#include "palpate/calibration/noise/touch_noise.h"
#include "palpate/core/expected.h"
#include "palpate/math/estimate.h"
#include "palpate/math/pose.h"

namespace palpate::calibration {

struct TouchedPoint {
  Point<World> place;
  int corner = 0;  // 1 to 4 in touching order; 0 = somewhere on the surface
  // m^2, of the tracker's error there, which touches of one corner share. Zero: none that is known of; what
  // it adds by chance then counts as the hand's.
  Matrix3 tracker = Matrix3::Zero();
};

struct RectangleFit {
  Pose<World, Rectangle> X_world_rectangle;
  double width = 0.0, height = 0.0;  // m, corner 1 to 2 and 1 to 4
  rig::TouchNoise seen;              // of the hand, as these touches alone tell
  rig::TouchNoise touch;             // with what was known before; the covariance rests on it
  // 1 to 4
  Point<World> corner(int number) const;
};

struct RectangleOptions {
  double tolerance = 0.02;                        // largest misfit of a corner, as a part of the diagonal
  double least_tolerance = 0.003;                 // m, ten times what a hand misses a corner by
  rig::TouchNoise touch = noise::kPresumedTouch;  // known of the hand before
  bool learn = true;  // false: that is all there is to know, these touches are part of it
};

// Without corner numbers (all 0) the first four points are the corners in order.
Expected<Estimate<RectangleFit>> fit_rectangle(std::vector<TouchedPoint> points,
                                               const RectangleOptions& options = {});

struct SurfaceTouches {
  std::string name;
  std::vector<TouchedPoint> points;
};

// Several that one hand has touched: what it misses by is learned from all of them and then counts in each.
// A refusal names the surface where there are several.
Expected<std::vector<Estimate<RectangleFit>>> fit_rectangles(const std::vector<SurfaceTouches>& touched,
                                                             const RectangleOptions& options = {});

}  // namespace palpate::calibration
