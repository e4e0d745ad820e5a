#include "palpate/desktop/session_curves.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "palpate/core/units.h"
#include "palpate/desktop/drawing.h"
#include "palpate/desktop/session_colours.h"

namespace palpate::desktop {
namespace {

// The ends of a scale that holds all values: powers of ten, each with its half and fifth, so that it changes seldom.
void fit_scale(Curve& curve) {
  double low = 1e9, high = 0.0;
  for (const double value : curve.values)
    if (std::isfinite(value) && value > 0.0) low = std::min(low, value), high = std::max(high, value);
  if (high <= 0.0) low = 0.1, high = 1.0;
  const auto round_scale = [](double value, bool up) {
    const double decade = std::pow(10.0, std::floor(std::log10(value)));
    double best = up ? 10.0 * decade : decade;
    for (const double step : {1.0, 2.0, 5.0})
      if (up ? step * decade >= value * (1.0 - 1e-9) : step * decade <= value * (1.0 + 1e-9)) {
        best = step * decade;
        if (up) break;
      }
    return best;
  };
  curve.low = round_scale(low, false);
  curve.high = std::max(round_scale(high, true), 2.0 * curve.low);
}

}  // namespace

std::vector<Curve> guidance_curves(const std::vector<calibration::session::GuidanceState>& states, int of) {
  Curve error{"Predicted error", "not known yet", {}, of, true};
  Curve rest{"Range not visited yet", "", {}, of, false, 0.0, 100.0};
  for (const auto& state : states) {
    error.values.push_back(mm_from_metres(state.predicted_error));
    rest.values.push_back(100.0 * (1.0 - state.coverage));
  }
  if (!states.empty()) {
    rest.newest = fmt::format("{:.0f} %", rest.values.back());
    if (const double now = error.values.back(); std::isfinite(now))
      error.newest = fmt::format("{:.2f} mm", now);
  }
  fit_scale(error);
  return {error, rest};
}

Eigen::Vector2d curve_place(const Curve& curve, std::size_t index, const Box& box) {
  const double value = curve.values.at(index);
  const double along = curve.of > 1 ? static_cast<double>(index) / (curve.of - 1) : 0.0;
  const double share = curve.logarithmic ? std::log(value / curve.low) / std::log(curve.high / curve.low)
                                         : (value - curve.low) / (curve.high - curve.low);
  return {box.x + along * box.width, box.y + (1.0 - share) * box.height};
}

void draw_curve(Canvas& canvas, Lettering& lettering, const Curve& curve, const Box& box, int letter) {
  const int small = std::max(8, letter * 3 / 4), line = lettering.line_height(letter);
  lettering.write(canvas, box.x, box.y, curve.title, letter, kInkGrey);
  lettering.write(canvas, box.x + box.width - lettering.width(curve.newest, letter), box.y, curve.newest,
                  letter, kInkWhite);
  const auto number = [&](double value) {
    return curve.logarithmic ? fmt::format("{:g}", value) : fmt::format("{:.0f}", value);
  };
  const int left =
      std::max(lettering.width(number(curve.low), small), lettering.width(number(curve.high), small));
  const int under = lettering.line_height(small);
  const int top = line + under / 2;  // the uppermost number stays below the title
  const Box plot{box.x + left + letter / 2, box.y + top, box.width - left - letter, box.height - top - under};
  if (plot.width <= 4 || plot.height <= 4) return;
  for (const double value : {curve.low, curve.high}) {
    const int y = value == curve.high ? plot.y : plot.y + plot.height;
    canvas.rectangle(plot.x, y, plot.width, 1, kPageLine);
    const std::string words = number(value);
    lettering.write(canvas, plot.x - letter / 3 - lettering.width(words, small), y - under / 2, words, small,
                    kInkGrey);
  }
  const std::string end = fmt::format("{} poses", curve.of);
  lettering.write(canvas, plot.x + plot.width - lettering.width(end, small), plot.y + plot.height + 2, end,
                  small, kInkGrey);
  std::optional<Eigen::Vector2d> before;
  for (std::size_t i = 0; i < curve.values.size(); ++i) {
    if (!std::isfinite(curve.values[i])) continue;
    const Eigen::Vector2d at = curve_place(curve, i, plot);
    if (before) draw_line(canvas, *before, at, std::max(1.5, 0.12 * letter), kPresent);
    before = at;
  }
  if (before) draw_disc(canvas, *before, 0.22 * letter, kInkWhite);
}

}  // namespace palpate::desktop
