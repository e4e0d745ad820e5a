// Errors that change smoothly with the pose - a tracker's bias field, a lens a little wrong, a bent board:
// how large they are, told from the residuals, and what they do to an estimate.
//
// Model: the error of component c of observation i is white noise of variance v_c d_i plus a random field of
// variance s_c whose correlation between two poses is exp(-D^2 / 2 L^2), D^2 = |place - place'|^2 +
// (lever angle)^2. Unlike a correlation in time, the field knows that poses seen again repeat their error. A
// field much longer than the motion is all but linear in the pose; the fit follows it and leaves no residual,
// so that only the part that can be seen tells how large the unseen one must be. Hence restricted maximum
// likelihood (Patterson & Thompson 1971) of all components together, averaged over a grid of s_c / v_c and of
// L, both equally likely a priori in the logarithm. The covariance added to an estimate whose influence
// functions are G is then sum_c s_c G_c K G_c^T. Any units; pure function.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "palpate/math/so3.h"

namespace palpate::calibration::noise {

// One row for each observation, or for each group of neighbouring ones taken together.
struct PoseErrors {
  std::vector<Vector3> place;    // m
  std::vector<Quaternion> turn;  // same length
  double lever = 0.2;            // m: by how much a place must change to matter like a radian
  Eigen::MatrixXd residual;      // rows x components
  Eigen::VectorXd white;         // rows: relative variance of the white part, 1 / observations in the group
  std::vector<Eigen::MatrixXd> jacobian;   // per component: rows x parameters
  std::vector<Eigen::MatrixXd> influence;  // per component: parameters x rows; estimate's change by an error
  // Per row, or none: components = axes * error in axes that do not turn with the pose; components then come
  // in threes, a vector each. Whose axes the field keeps to - the tracker's or the turning body's - cannot be
  // told; with these half of it keeps to either.
  std::vector<Eigen::MatrixXd> axes;
};

struct SmoothError {
  Eigen::MatrixXd covariance;  // of the parameters, from the field alone
  Eigen::VectorXd field_sd;    // per component
  double length = 0.0;         // m, mean of L over what is likely (geometric)
  struct Candidate {
    double length = 0.0, weight = 0.0;  // m; weights sum to 1
    Eigen::VectorXd variance;           // per component
  };
  std::vector<Candidate> candidates;  // what the means are made of
};

// At most about 300 rows are wise: the work grows with their third power. Fewer than 12 rows, or no motion at
// all, give a covariance of zero.
SmoothError smooth_error(const PoseErrors& errors);

// What a field told from other observations of the same devices does to this estimate; residuals do not
// matter.
Eigen::MatrixXd smooth_error_covariance(const PoseErrors& errors, const SmoothError& told);

}  // namespace palpate::calibration::noise
