// Landmarks from the pointer: the dots on table and walls, each touched in its middle once or several times.
//
// A landmark's place is the mean of its touches; its normal that of the calibrated surface it lies nearest
// to, which says how the dot looks from the camera. Covariance (m^2, World): what the person misses by,
// averaged over the touches - as known of the hand before, pooled with how touches of the same dots scatter -
// and the tracker's own, which touches of one place share. Pictures make the places better afterwards
// (landmark_refinement.h). Metres, frame World. Pure function. Refused: no surface, touches of one dot that
// lie apart, numbers that are not finite.
#pragma once

#include <string>
#include <vector>

#include "palpate/calibration/noise/touch_noise.h"
#include "palpate/core/expected.h"
#include "palpate/math/estimate.h"
#include "palpate/rig/rig.h"

namespace palpate::calibration {

struct LandmarkTouch {
  std::string label;  // touches of one label belong to one dot
  Vector3 place = Vector3::Zero();
  Matrix3 tracker = Matrix3::Zero();  // the tracker's covariance, m^2; what the person missed by is not in it
};

struct LandmarkTouchOptions {
  rig::TouchNoise touch = noise::kPresumedTouch;  // known of the hand before, mostly from surfaces' corners
  double diameter = 0.008;                        // m, of the dots
};

struct TouchedLandmarks {
  std::vector<rig::Landmark> landmarks;  // in the order of their first touches
  std::vector<std::string> labels;       // of each
  std::vector<std::string> surface;      // the one it lies on
  std::vector<double> distance;          // m, from that surface's plane
  std::vector<int> touches;
  rig::TouchNoise touch;  // of the hand, with what was known before; the covariance rests on it
};

// `residuals`: touch minus its landmark's place, in the order of the touches. Covariance: 3 per landmark.
Expected<Estimate<TouchedLandmarks>> landmarks_from_touches(
    const std::vector<LandmarkTouch>& touches, const std::vector<rig::SurfaceCalibration>& surfaces,
    const LandmarkTouchOptions& options = {});

}  // namespace palpate::calibration
