// Where a moving body is a little later than it was last heard of: what a contact law, which the haptic tick evaluates,
// makes of the newest place that the physics loop has handed it.
//
// Velocity and spin stay as they are, for at most kLongestCarry: a physics loop that stands still does not send the body
// away. World frame, SI. Pure; no allocation.
#pragma once

#include <algorithm>

#include "palpate/math/pose.h"
#include "palpate/time/instant.h"

namespace palpate::scene {

inline constexpr Duration kLongestCarry = std::chrono::milliseconds(3);

// `motion`: time, velocity of the body's origin, spin. A body that rests stays where it is to the last bit.
template <typename Frame, typename Motion>
Pose<World, Frame> carried_on(Pose<World, Frame> X, const Motion& motion, Instant<PhysicsClock> time) {
  const double ahead = to_seconds(std::clamp(time - motion.time, Duration(0), kLongestCarry));
  if (ahead == 0.0 || (motion.velocity.isZero(0.0) && motion.spin.isZero(0.0))) return X;
  X.translation += ahead * motion.velocity;
  X.rotation = (so3_exp(ahead * motion.spin) * X.rotation).normalized();
  return X;
}

}  // namespace palpate::scene
