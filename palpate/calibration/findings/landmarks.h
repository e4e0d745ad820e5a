// Dots on real surfaces from touches of the pointer: what landmarks_from_touches finds, and which dots lie off.
#pragma once

#include <vector>

#include "palpate/calibration/findings/findings.h"
#include "palpate/calibration/touched_landmarks.h"

namespace palpate::calibration::findings {

inline constexpr double kStatedFreedoms = 1e6;  // of TouchNoise: who states how far a hand misses knows it

inline constexpr double kOffSurface = 0.010;  // m; a dot further from every surface lies on none of them

struct LandmarkFindings {
  Estimate<TouchedLandmarks> estimate;
  Json json;
};

Expected<LandmarkFindings> find_landmarks(std::vector<LandmarkTouch> touches,
                                          const std::vector<rig::SurfaceCalibration>& surfaces,
                                          const LandmarkTouchOptions& options = {});

}  // namespace palpate::calibration::findings
