// Hand-eye calibration from the board's corners themselves, in one least-squares solve in pixels.
//
// Equation: u_ij = project(lens, (hand(t_i + delay) X)^-1 Z b_j) + noise, with hand = X_World_CameraMarker,
// X = X_CameraMarker_CameraOptical, Z = X_World_Board, b_j the corners in Board and t_i the view's time. Solved for
// X, Z and, where they are free, the lens (fx fy cx cy k1 k2 p1 p2 k3, Brown-Conrady) and the delay
// (palpate/math/levenberg_marquardt.h). The tracker errs by a small turn and shift e_i in every view, normal with a
// deviation per axis each: it is eliminated from the equations of its view (Schur complement), and its deviations
// are told by the residuals (expectation-maximisation, Dempster, Laird, Rubin 1977) unless they are stated. Corners
// far off and views whose e_i is far off weigh less. The covariance is that of the equations, so that few views
// say how little they know. Start: every view's board pose and calibrate_hand_eye, or where that refuses, the best
// of 24 ways to mount a camera. Metres, pixels, radians, seconds. Pure functions.
#pragma once

#include <string>
#include <vector>

#include "palpate/core/expected.h"
#include "palpate/device/pose_file.h"
#include "palpate/math/estimate.h"
#include "palpate/vision/board.h"

namespace palpate::vision {

struct PixelHandEyeOptions {
  bool free_lens = false;  // the model given is the start then
  bool free_delay = false;
  double delay_s = 0.0;                  // used as it is where it is not free
  double max_hand_gap_s = 0.1;           // a view is used where hand poses this close together enclose it
  double turn_sd = 0.0, place_sd = 0.0;  // of the hand poses, rad and m per axis; 0: told by the residuals
};

struct PixelHandEye {
  Pose<CameraMarker, CameraOptical> X_marker_camera;
  Pose<World, Board> X_world_board;
  double delay_s = 0.0;  // hand time = view time + delay
  device::CameraModel lens;
  double rms_px = 0.0;    // sqrt(sum |r|^2 / corners), as OpenCV's; the tracker's part is in it
  double noise_px = 0.0;  // per axis, of single corners
  double turn_sd = 0.0, place_sd = 0.0;  // rad and m per axis: of the hand poses, found or stated
  // Of the views' hand errors, found from each view alone: what the pose of one view is off.
  double rotation_residual_median = 0.0, translation_residual_median = 0.0;  // rad, m
  double board_scale = 1.0,
         board_scale_sd = 0.0;  // by which the squares would fit better, and how well it is known
  double untold_delay_s = 0.0,
         untold_delay_sd = 0.0;    // the same of a delay that was not free; 0 without times
  double rotation_range = 0.0;     // rad, largest angle between two hand poses used
  std::vector<std::string> views;  // used
  std::vector<std::string> warnings;
};

// `view_time_s`: a time for each view, on a clock that leads to the hand's by the delay. Empty: hand pose i belongs
// to view i, and there is no delay. Covariance order: X rotation (rad, CameraMarker axes, left perturbation), X
// translation (m), Z rotation (World axes), Z translation, delay (s), lens 9; zero where something is not free.
// Refused: fewer than 4 views, hand poses that fit much better the other way round.
Expected<Estimate<PixelHandEye>> calibrate_hand_eye_pixels(std::vector<device::StampedPose> hand,
                                                           const std::vector<BoardView>& views,
                                                           const std::vector<double>& view_time_s,
                                                           const device::CameraModel& lens,
                                                           const PixelHandEyeOptions& options = {});

}  // namespace palpate::vision
