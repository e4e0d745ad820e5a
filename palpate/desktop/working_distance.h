// How far away that is what somebody works at: where a headset's flat picture has to stand, for there alone shifts of
// the head are corrected.
//
// Depth of the stylus' tip along the camera's axis, smoothed so that the picture does not swing with the hand. CameraOptical,
// metres; times of the graphics host. Value; one thread.
#pragma once

#include <algorithm>
#include <cmath>
#include <optional>

#include "palpate/math/pose.h"
#include "palpate/time/instant.h"

namespace palpate::desktop {

class WorkingDistance {
 public:
  static constexpr double kFirst = 0.6, kNearest = 0.25, kFarthest = 2.0;  // m
  static constexpr double kSmooth_s = 0.5;

  // The tip as the camera has it; behind the camera it says nothing.
  double look(const Point<CameraOptical>& tip, Instant<GraphicsClock> now) {
    if (!(tip.m.z() > 0.0)) return distance();
    const double depth = std::clamp(tip.m.z(), kNearest, kFarthest);
    const double dt = seen_ ? std::max(0.0, to_seconds(now - *seen_)) : 0.0;
    distance_ = seen_ ? depth + (distance_ - depth) * std::exp(-dt / kSmooth_s) : depth;
    seen_ = now;
    return distance_;
  }
  double distance() const { return distance_; }

 private:
  double distance_ = kFirst;
  std::optional<Instant<GraphicsClock>> seen_;
};

}  // namespace palpate::desktop
