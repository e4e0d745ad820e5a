#include "palpate/rig/doubtful_values.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "palpate/core/units.h"
#include "palpate/device/lens_fold.h"
#include "palpate/math/place_text.h"

namespace palpate::rig {
namespace {

// From a long lens (a tenth of a radian and more) to where a pinhole's picture grows without bound.
constexpr double kNarrowest = 15.0, kWidest = 150.0, kWidestFisheye = 200.0;  // deg
constexpr double kSquarePixels = 1.25;                                        // one side over the other

// From one side of the picture to the other through its middle, as the lens sees it without the bend of its last terms.
double seen_deg(double pixels, double focal, device::LensKind kind) {
  const double half = 0.5 * pixels / focal;
  return degrees_from_radians(2.0 * (kind == device::LensKind::fisheye ? half : std::atan(half)));
}

void judge_lens(const std::string& part, const device::CameraModel& lens, std::vector<DoubtfulValue>& found) {
  const auto doubt = [&](std::string what) { found.push_back({part, std::move(what)}); };
  if (!(lens.cx > -0.5 && lens.cx < lens.width - 0.5 && lens.cy > -0.5 && lens.cy < lens.height - 0.5))
    doubt(fmt::format(
        "its centre cx_px, cy_px ({:.1f}, {:.1f}) lies outside its picture of {} x {} px; correct width_px, "
        "height_px or the centre",
        lens.cx, lens.cy, lens.width, lens.height));
  const double across = seen_deg(lens.width, lens.fx, lens.kind),
               down = seen_deg(lens.height, lens.fy, lens.kind);
  const double widest = lens.kind == device::LensKind::fisheye ? kWidestFisheye : kWidest;
  if (across > widest || down > widest || std::max(across, down) < kNarrowest)
    doubt(fmt::format(
        "it would see {:.0f} x {:.0f} deg, {:.0f} to {:.0f} are expected; fx_px, fy_px and the picture's "
        "size belong to one resolution",
        across, down, kNarrowest, widest));
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

constexpr double kSameTip = 0.005;  // m; pivot and arm find one tip to a fraction of this
constexpr double kNearTip = 0.002;  // m; and nearer than this whatever is stated
constexpr double kManyDeviations =
    8.0;  // of both together: nothing that a deviation does not count is as large

// One tip, found in two ways, by what both state of it.
bool are_apart(const ArmCalibration& arm, const PivotCalibration& pivot) {
  const Vector3 between = arm.tip_in_marker - pivot.tip_in_marker;
  const double apart = between.norm();
  if (apart > kSameTip) return true;
  const Eigen::Index at = 2 * arm.model.joint_count() + 6;
  if (apart < kNearTip || arm.covariance.rows() < at + 3) return false;
  const Vector3 along = between / apart;
  const Matrix3 both = arm.covariance.block<3, 3>(at, at) + pivot.covariance;
  return apart > kManyDeviations * std::sqrt(std::max(0.0, along.dot(both * along)));
}

void judge_tips(const Rig& rig, std::vector<DoubtfulValue>& found) {
  const auto judge = [&](const char* part, const std::optional<PivotCalibration>& pivot) {
    if (pivot && pivot->tip_in_marker.norm() > kStylusReach)
      found.push_back({part, fmt::format("its tip at {} is {:.0f} mm from its marker, more than a stylus "
                                         "reaches; check the unit and the direction of the poses, and "
                                         "calibrate it again",
                                         place_text_mm(pivot->tip_in_marker),
                                         mm_from_metres(pivot->tip_in_marker.norm()))});
    if (pivot && pivot->tip_in_marker.norm() < kNearestTip)
      found.push_back(
          {part, fmt::format("its tip is only {:.3f} mm from its marker's origin; check the unit of the "
                             "poses (_mm or _m), and calibrate it again",
                             mm_from_metres(pivot->tip_in_marker.norm()))});
  };
  judge("tip_pivot", rig.tip_pivot);
  judge("pointer_pivot", rig.pointer_pivot);
  // An arm calibrated by measured tips has none of its own.
  if (!rig.arm || !rig.tip_pivot || rig.arm->tip_in_marker.isZero()) return;
  const double apart = (rig.arm->tip_in_marker - rig.tip_pivot->tip_in_marker).norm();
  if (are_apart(*rig.arm, *rig.tip_pivot))
    found.push_back(
        {"arm", fmt::format("its tip at {} in the marker lies {:.1f} mm from that of tip_pivot "
                            "at {}; calibrate pivot and arm again, with one stylus and one marker",
                            place_text_mm(rig.arm->tip_in_marker), mm_from_metres(apart),
                            place_text_mm(rig.tip_pivot->tip_in_marker))});
}

void judge_delays(const DelayCalibration& delays, std::vector<DoubtfulValue>& found) {
  for (const auto& [name, delay_s] : {std::pair{"tracker_after_arm_s", delays.tracker_after_arm_s},
                                      std::pair{"camera_after_tracker_s", delays.camera_after_tracker_s}})
    if (!(std::abs(delay_s) <= kLongestDelay))
      found.push_back(
          {"delays", fmt::format("{} is {:.6g} s, at most {:g} s is expected: the clocks that stamped have "
                                 "different origins; measure it with the devices as they are used, or "
                                 "set it to 0",
                                 name, delay_s, kLongestDelay)});
}

}  // namespace

std::vector<DoubtfulValue> doubtful_values(const Rig& rig) {
  std::vector<DoubtfulValue> found;
  if (rig.delays) judge_delays(*rig.delays, found);
  judge_tips(rig, found);
  if (rig.camera) judge_lens("camera", rig.camera->model, found);
  if (rig.right_camera) judge_lens("right_camera", rig.right_camera->model, found);
  return found;
}

}  // namespace palpate::rig
