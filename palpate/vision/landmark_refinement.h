// Landmarks made better than the hand that touched them: many pictures of the resting landmarks from a moving
// head.
//
// The user touches each landmark with the pointer (0.3 mm at best), then looks at them while turning the
// head. Minimised over the landmarks' places L, the marker's pose M_f of every frame, one correction of the
// hand-eye transform X and one of the lens C:
//   sum rho(r' S^-1 r) + every unknown's deviation from its prior, whitened,   r = project_C((M_f X)^-1 L) -
//   u
// by Levenberg-Marquardt; the frames' poses are eliminated by the Schur complement. The pictures fix the
// landmarks' shape, the touches (on average) where that shape is. The lens is an unknown because its errors
// and the landmarks' hang together afterwards: landmarks are moved to where this lens shows them. The
// tracker's bias is nearly the same in all frames and would otherwise be believed as often as there are
// frames: `shared_*` in the options gives the hand-eye correction room for it. How far the hand missed is
// found on the way, where it is asked for: the touches' covariance is T + s^2 I, and s^2 the variance
// component (Foerstner 1979, restricted maximum likelihood) under which the places' moves away from the
// touches are as large as they should be,
//   s^2 = (f0 s0^2 + s^4 sum e' P P e) / (f0 + s^2 sum tr(P - P Q P)),   e moves, P touches' weights, Q
//   places'
// Metres, pixels, radians.
// Source: Triggs et al. (2000), "Bundle adjustment - a modern synthesis". Pure function.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "palpate/calibration/noise/touch_noise.h"
#include "palpate/core/expected.h"
#include "palpate/math/estimate.h"
#include "palpate/vision/pose_refinement.h"

namespace palpate::vision {

struct LandmarkFrame {
  Pose<World, CameraMarker> X_world_marker;  // from the tracker, at the image's mid-exposure
  Matrix6 covariance = Matrix6::Zero();
  std::vector<Sighting> sightings;
};

struct LandmarkRefinementOptions {
  double pixel_sd = 0.1;  // px per axis, beyond what each sighting states
  double huber = 2.0;     // whitened length
  bool correct_hand_eye = true;
  double shared_rotation_sd = 1e-3;  // rad: the tracker's bias over a marker's width, as a turn of the marker
  double shared_translation_sd = 1e-4;  // m
  int max_iterations = 50;
  // What is known of the hand; the landmarks' covariance holds this sd once for each, as after one touch.
  // None: their covariance is taken as it is.
  std::optional<rig::TouchNoise> touch;
};

struct LandmarkRefinement {
  std::vector<rig::Landmark> landmarks;  // covariance updated
  rig::HandEyeCalibration hand_eye;      // as it fits these pictures; the prior where it is not corrected
  rig::CameraCalibration camera;         // the same; the prior where that states no covariance
  rig::TouchNoise touch;                 // of the hand, in the end; empty where nothing was asked
  int sightings = 0, inliers = 0;
  double rms_px_before = 0.0, rms_px = 0.0;  // tracker and touched places alone; after. sqrt(sum |r|^2 / n)
};

// Covariance in the order of Rig::registration_covariance: lens (zero where its prior says nothing), hand-eye
// (zero where not corrected), then each landmark's place (m). `residuals` = refined minus touched place.
// Refuses where fewer than 3 landmarks are seen from at least 5 frames.
Expected<Estimate<LandmarkRefinement>> refine_landmarks(const rig::CameraCalibration& camera,
                                                        const rig::HandEyeCalibration& hand_eye,
                                                        const std::vector<rig::Landmark>& touched,
                                                        const std::vector<LandmarkFrame>& frames,
                                                        const LandmarkRefinementOptions& options = {});

}  // namespace palpate::vision
