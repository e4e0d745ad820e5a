#include "palpate/rig/doubtful_values.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "palpate/core/units.h"
#include "palpate/device/lens_fold.h"

namespace palpate::rig {
namespace {

// From a long lens (a tenth of a radian and more) to where a pinhole's picture grows without bound.
constexpr double kNarrowest = 15.0, kWidest = 150.0;  // deg
constexpr double kSquarePixels = 1.25;                // one side over the other

double seen_deg(double pixels, double focal) {
  return degrees_from_radians(2.0 * std::atan(0.5 * pixels / focal));
}

void judge_lens(const std::string& part, const device::CameraModel& lens, std::vector<DoubtfulValue>& found) {
  const auto doubt = [&](std::string what) { found.push_back({part, std::move(what)}); };
  if (!(lens.cx > -0.5 && lens.cx < lens.width - 0.5 && lens.cy > -0.5 && lens.cy < lens.height - 0.5))
    doubt(fmt::format(
        "its centre cx_px, cy_px ({:.1f}, {:.1f}) lies outside its picture of {} x {} px; correct width_px, "
        "height_px or the centre",
        lens.cx, lens.cy, lens.width, lens.height));
  const double across = seen_deg(lens.width, lens.fx), down = seen_deg(lens.height, lens.fy);
  if (across > kWidest || down > kWidest || std::max(across, down) < kNarrowest)
    doubt(fmt::format(
        "it would see {:.0f} x {:.0f} deg, {:.0f} to {:.0f} are expected; fx_px, fy_px and the picture's "
        "size belong to one resolution",
        across, down, kNarrowest, kWidest));
  const double ratio = std::max(lens.fx / lens.fy, lens.fy / lens.fx);
  if (ratio > kSquarePixels)
    doubt(
        fmt::format("fx_px and fy_px differ by a factor of {:.2f}; pixels are square, 1 is expected", ratio));
  if (device::folds_inside(lens))
    doubt(
        "its distortion turns back on itself inside the picture; calibrate again with views that reach into "
        "the "
        "picture's corners");
}

}  // namespace

std::vector<DoubtfulValue> doubtful_values(const Rig& rig) {
  std::vector<DoubtfulValue> found;
  if (rig.camera) judge_lens("camera", rig.camera->model, found);
  if (rig.right_camera) judge_lens("right_camera", rig.right_camera->model, found);
  return found;
}

}  // namespace palpate::rig
