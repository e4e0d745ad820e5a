// How good a calibration would be by now, as curves over the poses taken: the predicted error, and how much of the
// range no pose is in yet. Both fall.
//
// Pure, but for the letters.
#pragma once

#include <string>
#include <vector>

#include "palpate/calibration/session/guided_poses.h"
#include "palpate/desktop/letterbox.h"
#include "palpate/desktop/lettering.h"

namespace palpate::desktop {

struct Curve {
  std::string title, newest;   // "Predicted error", "0.12 mm"
  std::vector<double> values;  // one for each pose, in order; what is no number is left out
  int of = 0;                  // poses there will be
  bool logarithmic = false;    // of values above 0
  double low = 0.0, high = 1.0;
};

// Two: the error (mm, logarithmic) and the part of the range not visited yet (%).
std::vector<Curve> guidance_curves(const std::vector<calibration::session::GuidanceState>& states, int of);

// Where a value stands in a box, px; of the curve's own scale.
Eigen::Vector2d curve_place(const Curve& curve, std::size_t index, const Box& box);

void draw_curve(Canvas& canvas, Lettering& lettering, const Curve& curve, const Box& box, int letter);

}  // namespace palpate::desktop
