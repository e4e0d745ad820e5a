#include "palpate/scene/player.h"

namespace palpate::scene {

bool Reach::contains(const Vector3& tip_world) const {
  Vector3 theta;
  if (!device::phantom_inverse(X_world_base.inverse() * Point<World>{tip_world}, lengths, theta))
    return false;
  return ((theta - joints[0]).array() > margin).all() && ((joints[1] - theta).array() > margin).all() &&
         theta[1] - theta[2] < widest_elbow - margin;
}

bool Reach::contains(const Quintic& path) const {
  constexpr int kSamples = 12;
  for (int i = 1; i <= kSamples; ++i) {
    if (!contains(path.at(path.duration() * i / kSamples).position)) return false;
  }
  return true;
}

Vector3 Reach::home() const {
  constexpr double kShoulder = 0.52, kElbow = 0.30;  // rad: 30 and 17 degrees, the middle of the upper half
  return (X_world_base * device::phantom_tip({0.0, kShoulder, kElbow}, lengths)).m;
}

}  // namespace palpate::scene
