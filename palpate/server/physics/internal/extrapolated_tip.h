// The stylus as it is at the physics loop's tick, which comes up to a period of the haptic loop after its
// reading: moved on steadily by its own velocity. In lock-step both ticks have one time and nothing moves.
//
// Without it a state shows the stylus where it was half a millisecond ago on average, more on a busy machine:
// at 2 m/s a millimetre and more. A haptic loop that stands still does not send the stylus away: it is
// carried on for kLongestCarry at most. World, SI. Pure, no allocation.
#pragma once

#include <algorithm>

#include "palpate/math/so3.h"
#include "palpate/scene/application.h"

namespace palpate::server::physics {

inline constexpr Duration kLongestCarry = std::chrono::milliseconds(3);

inline scene::TipState extrapolated_to(scene::TipState tip, Instant<PhysicsClock> now) {
  const Duration age = std::min(now - tip.time, kLongestCarry);
  if (age <= Duration(0)) return tip;
  const double s = to_seconds(age);
  tip.time += age;
  auto& X = tip.X_world_tip;
  X.translation += s * tip.velocity;
  X.rotation = (so3_exp(s * tip.angular_velocity) * X.rotation).normalized();
  return tip;
}

}  // namespace palpate::server::physics
