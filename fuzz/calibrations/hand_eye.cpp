// Two recordings of poses into the hand-eye calibration, with and without the delay of their clocks.
#include "palpate/calibration/hand_eye.h"

#include "fuzz/check.h"
#include "fuzz/split.h"

namespace palpate::fuzz {

Refusals hand_eye(std::string_view file) {
  Refusals refusals;
  const auto [first, second] = split_files(file);
  auto hand = device::parse_poses(first, "hand.csv");
  auto eye = device::parse_poses(second, "eye.csv");
  if (!answered(hand, refusals) || !answered(eye, refusals)) return refusals;
  cut(hand->poses, 2 * kMostRows);
  cut(eye->poses);
  for (const bool estimate_delay : {false, true}) {
    calibration::HandEyeOptions options{.estimate_delay = estimate_delay};
    if (!hand->has_time) options.max_hand_gap_s = 1.5;
    const auto fit = calibration::calibrate_hand_eye(hand->poses, eye->poses, options);
    if (!answered(fit, refusals)) continue;
    hold_finite(fit->value.X_marker_camera, "the camera's pose in the marker is rigid");
    hold_finite(fit->value.X_world_board, "the board's pose is rigid");
    hold_finite(fit->value.delay_s, "a delay is finite");
    hold_finite(fit->value.delay_std_s, "a delay's deviation is finite");
  }
  return refusals;
}

}  // namespace palpate::fuzz
