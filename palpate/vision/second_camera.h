// A second camera fitted to landmarks whose places the first one's pictures have settled.
//
// Each camera's pictures can move the landmarks (landmark_refinement.h), each a little otherwise; but a thing
// must be at one place for both eyes. So the landmarks stay where the first camera has put them, and lens and
// hand-eye transform of the second become what its own pictures say given those places: the solution of its
// own solve, moved by the regression of these unknowns on the landmarks. Errors of the places then come into
// both eyes alike, and the covariance says so:
//   S_c|L = S_cc - G S_Lc,   G = S_cL S_LL^-1   (of its own solve; the places' prior there plays no part)
//   C = [ S_c|L + G C_LL G'   G C_LL ;  C_LL G'   C_LL ]   with C_LL the places' covariance from the first
// World frame, metres, radians, pixels. Pure function. Source: conditional normal distribution, e.g. Bishop
// (2006), "Pattern Recognition and Machine Learning", section 2.3.1.
#pragma once

#include "palpate/vision/landmark_refinement.h"

namespace palpate::vision {

struct SecondCamera {
  rig::CameraCalibration camera;
  rig::HandEyeCalibration hand_eye;
  Eigen::MatrixXd covariance;  // as Rig::registration_covariance
};

// `own`: the second camera's solve over the same landmarks. `kept` with the covariance of the first camera's
// solve, in that order, too. Throws std::invalid_argument where their sizes do not agree.
SecondCamera fit_second_camera(const Estimate<LandmarkRefinement>& own,
                               const std::vector<rig::Landmark>& kept,
                               const Eigen::MatrixXd& kept_covariance);

}  // namespace palpate::vision
