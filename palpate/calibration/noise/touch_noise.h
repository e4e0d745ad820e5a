// By how much a hand misses what it touches, learned from its touches.
//
// A `TouchNoise` is what is known of that: a standard deviation per axis and the freedoms (independent
// residuals) it rests on, a scaled inverse chi-square distribution. What several surfaces say of one hand is
// pooled, weighed by their freedoms. Before anybody has touched anything a hand is presumed to miss by
// 0.3 mm, as if two residuals had said so: enough that four touches which happen to fit well are not taken
// for a perfect hand, and too little to hold up against a dozen that say otherwise. Metres. Pure functions.
// Source: Gelman et al. (2013), "Bayesian data analysis", section 2.6 (variance of a normal).
#pragma once

#include <cmath>

#include "palpate/rig/rig.h"

namespace palpate::calibration::noise {

inline constexpr rig::TouchNoise kPresumedTouch{0.0003, 2.0};

// Of one hand; one without freedoms says nothing.
inline rig::TouchNoise pooled(const rig::TouchNoise& a, const rig::TouchNoise& b) {
  const double freedoms = a.freedoms + b.freedoms;
  if (!(freedoms > 0.0)) return a;
  return {std::sqrt((a.freedoms * a.sd * a.sd + b.freedoms * b.sd * b.sd) / freedoms), freedoms};
}

// What a rig's surfaces tell of the hand that touched them.
inline rig::TouchNoise touch_noise_of(const std::vector<rig::SurfaceCalibration>& surfaces) {
  rig::TouchNoise hand = kPresumedTouch;
  for (const auto& surface : surfaces) hand = pooled(hand, surface.touch);
  return hand;
}

}  // namespace palpate::calibration::noise
