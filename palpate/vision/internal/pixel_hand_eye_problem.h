// The least-squares problem of a hand-eye calibration in pixels: residuals, derivatives and the elimination of the
// tracker's error in each view. See pixel_hand_eye.h for the equation. Pure functions.
#pragma once

#include <optional>
#include <vector>

#include "palpate/device/pose_file.h"
#include "palpate/math/levenberg_marquardt.h"
#include "palpate/vision/board.h"

namespace palpate::vision {

// Order of the unknowns: X 6, Z 6, delay, lens 9, the board's scale.
inline constexpr Eigen::Index kDelayAt = 12, kLensAt = 13, kScaleAt = kLensAt + device::kLensParameters,
                              kPixelUnknowns = kScaleAt + 1;

struct PixelState {
  Pose<CameraMarker, CameraOptical> X;
  Pose<World, Board> Z;
  double delay_s = 0.0;
  device::CameraModel lens;
  double scale = 1.0;

  PixelState moved(const Eigen::VectorXd& step) const;
};

// What is known of the errors: corners in px per axis, the tracker in rad and m per axis, and how single corners
// and views weigh.
struct PixelNoise {
  double corner = 1.0, turn = 2e-3, place = 1e-3;
  std::vector<Eigen::VectorXd> corner_weight;  // of each view
  std::vector<double> view_weight;
};

struct PixelProblem {
  const std::vector<device::StampedPose>& hand;  // by time
  const std::vector<BoardView>& views;
  const std::vector<double>& time_s;  // of each view
  double max_hand_gap_s = 0.1;
  Eigen::Matrix<bool, Eigen::Dynamic, 1> free;  // of the 23 unknowns

  // The hand at a view, and its velocities in World axes; none where the stream does not enclose the moment.
  struct Hand {
    Pose<World, CameraMarker> pose;
    Vector3 w = Vector3::Zero(), v = Vector3::Zero();
  };
  std::optional<Hand> hand_at(double time_s) const;

  // A view's residuals (px, seen minus computed is negative of this: computed - seen), by unknowns and by the
  // hand's error. False where the hand is not known or a corner would be behind the camera.
  struct View {
    Eigen::VectorXd r;
    Eigen::MatrixXd J, G;  // 2 n x 23, 2 n x 6
  };
  bool linearise(const PixelState& x, std::size_t view, View& out) const;

  // Half of minus twice the logarithm of the likelihood, the tracker's errors eliminated; with the equations.
  double evaluate(const PixelState& x, const PixelNoise& noise,
                  NormalEquations<Eigen::Dynamic>* equations) const;
  LeastSquaresResult solve(PixelState& x, const PixelNoise& noise, int most_iterations) const;
};

// A view's hand error given its residuals: the mean, the covariance, and what is left of the residuals.
struct HandError {
  Vector6 mean;
  Matrix6 covariance;
  Eigen::VectorXd left;
};
HandError hand_error(const PixelProblem::View& view, const Eigen::VectorXd& corner_weight, double view_weight,
                     const PixelNoise& noise);

}  // namespace palpate::vision
