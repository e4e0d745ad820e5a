// The stylus as the physics server knows it: measured joints through the calibrated arm. World frame, SI. Value.
#pragma once

#include "palpate/math/pose.h"
#include "palpate/time/instant.h"

namespace palpate::scene {

struct TipState {
  Instant<PhysicsClock> time;
  Pose<World, Tip> X_world_tip;
  Vector3 velocity = Vector3::Zero();
  Vector3 angular_velocity = Vector3::Zero();
};

}  // namespace palpate::scene
