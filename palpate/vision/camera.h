// A camera's lens from views of a chessboard, and a board's pose from one view with a known lens.
//
// Equation: u_ij = project(C, X_i b_j) + noise, solved for the lens C (fx fy cx cy k1 k2 p1 p2 k3 as
// Brown-Conrady, with k4 k5 k6 of a rational lens, or fx fy cx cy k1 k2 k3 k4 of a fisheye lens) and the board's pose X_i in every view i by least squares over all pixels. Source: Zhang
// (2000), "A flexible new technique for camera calibration"; start and minimum by OpenCV's calibrateCamera, of a fisheye lens by our own solve,
// covariance by our own Schur complement. Metres, pixels, radians. Functions without state, safe from any
// thread. Too few or degenerate views are refused.
#pragma once

#include <string>
#include <vector>

#include "palpate/core/expected.h"
#include "palpate/device/camera_model.h"
#include "palpate/math/estimate.h"
#include "palpate/math/pose.h"
#include "palpate/vision/board.h"

namespace palpate::vision {

struct CameraOptions {
  bool reject_outlier_views = false;  // fit again without the flagged views
  bool free_k3 = true;                // of Brown-Conrady
  device::LensKind lens = device::LensKind::brown;
  // A view is flagged where its rms exceeds the median of all views by this many standard deviations, the
  // deviation taken from the median absolute deviation. In OpenCV's set the bad photograph lies at 27 and a
  // mediocre one, which is worth keeping, at 7.
  double outlier_deviations = 10.0;
};

struct ViewFit {
  std::string name;
  double rms_px = 0.0;  // sqrt(sum |r|^2 / N), as OpenCV's
  bool outlier = false;
  bool used = true;  // false where the view was flagged and left out
  Pose<CameraOptical, Board> X_camera_board;
};

struct CameraSolution {
  device::CameraModel model;
  double rms_px = 0.0;  // over the views used, sqrt(sum |r|^2 / N)
  std::vector<ViewFit> views;
  std::vector<std::string> warnings;

  std::vector<std::string> outlier_views() const;
};

// Covariance order: fx fy cx cy (px) and the coefficients as device::coefficient_names() has them, then zeros. `width` and `height` of the images in px.
Expected<Estimate<CameraSolution>> calibrate_camera(const std::vector<BoardView>& views, int width,
                                                    int height, const CameraOptions& options = {});

struct BoardPose {
  Pose<CameraOptical, Board> X_camera_board;
  double rms_px = 0.0;
  // A small or distant flat board fits nearly as well when tilted the other way: then this second minimum's
  // rms is close to the first's, and the pose must not be used.
  double second_rms_px = 0.0;
  bool ambiguous = false;
};

struct BoardPoseOptions {
  double max_rms_px = 2.0;  // above it the view is refused: wrong lens, wrong board or false corners
  double ambiguity_ratio =
      1.5;  // second minimum's rms over the first's below which the pose is called ambiguous
};

// Covariance order: rotation (rad, CameraOptical axes, left perturbation) then translation (m), scaled by the
// residuals.
Expected<Estimate<BoardPose>> board_pose(const device::CameraModel& camera, const BoardView& view,
                                         const BoardPoseOptions& options = {});

}  // namespace palpate::vision
