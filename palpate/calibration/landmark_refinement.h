// Landmarks made better than the hand that touched them: many pictures of the resting landmarks from a moving
// head.
//
// The user touches each landmark with the pointer (0.3 mm at best), then looks at them while turning the
// head. Minimised over the landmarks' places L, the marker's pose M_f of every frame and one correction of
// the hand-eye transform X:
//   sum rho(|project((M_f X)^-1 L_i) - u_fi|^2 / px^2) + every unknown's deviation from its prior, whitened
// by Levenberg-Marquardt; the frames' poses are eliminated by the Schur complement. The pictures fix the
// landmarks' shape, the touches (on average) where that shape is. The tracker's bias is nearly the same in
// all frames and would otherwise be believed as often as there are frames: `shared_*` in the options gives
// the hand-eye correction room for it. Metres, pixels, radians. Source: Triggs et al. (2000), "Bundle
// adjustment - a modern synthesis". Pure function.
#pragma once

#include <string>
#include <vector>

#include "palpate/calibration/pose_refinement.h"
#include "palpate/core/expected.h"
#include "palpate/estimation/estimate.h"

namespace palpate {

struct LandmarkFrame {
  Pose<World, CameraMarker> X_world_marker;  // from the tracker, at the image's mid-exposure
  Matrix6 covariance = Matrix6::Zero();
  std::vector<Sighting> sightings;
};

struct LandmarkRefinementOptions {
  double pixel_sd = 0.1;  // px per axis
  double huber = 2.0;     // whitened length
  bool correct_hand_eye = true;
  double shared_rotation_sd = 1e-3;  // rad: the tracker's bias over a marker's width, as a turn of the marker
  double shared_translation_sd = 1e-4;  // m
  int max_iterations = 50;
};

struct LandmarkRefinement {
  std::vector<Landmark> landmarks;  // covariance updated
  HandEyeCalibration hand_eye;      // as it fits these pictures; the prior where it is not corrected
  int sightings = 0, inliers = 0;
  // Of all landmarks as one body: turn (rad) about their mean place and shift (m), World axes. The pictures
  // do not know it; touches and tracker do.
  Matrix6 shared = Matrix6::Zero();
  double rms_px_before = 0.0, rms_px = 0.0;  // tracker and touched places alone; after. sqrt(sum |r|^2 / n)
};

// Covariance (rotation, rad, about their mean; translation, m; World axes) of the rigid motion that fits the
// errors of these places best, each place counting the same; `covariance` is 3N x 3N.
Matrix6 shared_motion(const std::vector<Vector3>& places, const Eigen::MatrixXd& covariance);

// Covariance order: hand-eye rotation and translation (zero where not corrected), then each landmark's place
// (m). `residuals` = refined minus touched place. Refuses where no landmark is seen from at least 5 frames.
Expected<Estimate<LandmarkRefinement>> refine_landmarks(const CameraModel& camera,
                                                        const HandEyeCalibration& hand_eye,
                                                        const std::vector<Landmark>& touched,
                                                        const std::vector<LandmarkFrame>& frames,
                                                        const LandmarkRefinementOptions& options = {});

}  // namespace palpate
