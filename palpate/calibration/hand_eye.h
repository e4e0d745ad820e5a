// Hand-eye calibration: where a camera sits in the marker it carries, from the marker's poses in the tracker
// (hand) and the camera's poses at a board (eye), and by how much the two clocks differ.
//
// Equation: hand(t + delay) X = Z eye(t), with hand = X_World_CameraMarker, X = X_CameraMarker_CameraOptical,
// Z = X_World_Board, eye = X_Board_CameraOptical and t the eye's time. Every eye pose gives six residuals in
// the camera's axes: rotation log((hand X)^-1 Z eye) and translation. Solved for X, Z and delay together
// (Levenberg-Marquardt, Cauchy loss); the residuals' 6x6 scatter is learnt from the residuals themselves, so
// that depth, sideways place and rotation weigh as they deserve. Start: hand_eye_start.h; delay by
// motion_correlation.h. Covariance: hand_eye_covariance.h, which knows that poses share errors in time and by
// the pose. Metres, radians, seconds. Pure function; refuses what cannot be observed and warns
// (hand_eye_motion.h) where the motion carries the answer badly.
#pragma once

#include <string>
#include <vector>

#include "palpate/core/expected.h"
#include "palpate/device/pose_file.h"
#include "palpate/math/estimate.h"

namespace palpate::calibration {

struct HandEyeOptions {
  bool estimate_delay = false;
  double delay_s = 0.0;         // used as it is where it is not estimated
  double max_hand_gap_s = 0.1;  // an eye pose is used where hand poses this close together enclose it
  // Whether a delay that is not estimated is compared with what an estimate would give, and warned of where that fits
  // clearly better. Needs true times, and as long as a solve with the delay.
  bool doubt_delay = true;
  // Refused where the turns fit and the places do not, as with columns in another order.
  bool doubt_places = true;
};

struct HandEyeSolution {
  Pose<CameraMarker, CameraOptical> X_marker_camera;
  Pose<World, Board> X_world_board;
  double delay_s = 0.0;  // hand time = eye time + delay
  double delay_std_s = 0.0;
  double rotation_residual_median = 0.0;     // rad
  double translation_residual_median = 0.0;  // m
  double translation_rms = 0.0;              // m, per component, inliers
  int pairs = 0;                             // eye poses used
  double rotation_range = 0.0;               // rad, largest angle between two hand poses used
  double second_axis_spread = 0.0;           // rad, rms turn about the second most turned axis
  double correlation_time_s = 0.0;           // of the residuals
  double grown_by = 1.0;                     // factor on the deviations because poses share errors
  double error_length = 0.0;                 // m, over which errors that change with the pose stay alike
  double method_scatter = 0.0;               // m, largest distance between closed-form answers
  std::vector<std::string> warnings;
};

// Covariance order: X rotation (rad, CameraMarker axes, left perturbation), X translation (m), Z rotation
// (World axes), Z translation, delay (s; zero where it is not estimated). Poses may come in any order; equal
// times are kept once. `inlier` and `residuals` (m, camera axes) belong to the eye poses used, in time order.
Expected<Estimate<HandEyeSolution>> calibrate_hand_eye(std::vector<device::StampedPose> hand,
                                                       std::vector<device::StampedPose> eye,
                                                       const HandEyeOptions& options = {});

}  // namespace palpate::calibration
