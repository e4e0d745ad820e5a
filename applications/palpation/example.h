// A moment worth a picture: the stylus presses into the organ. Pure but for the cache.
#pragma once

#include <vector>

#include "palpate/scene/application.h"

namespace palpate::applications::palpation {

// Pressed at a place of the upper side; where the stylus is does not matter.
scene::SceneState example_state(const scene::SceneDescription& scene, const Pose<World, Tip>& X_world_tip);
// The organ as it is then. Prepares it, which may take half a minute. Throws what PalpationApplication does.
std::vector<float> example_shape(const scene::SceneDescription& scene, const scene::SceneState& state);

}  // namespace palpate::applications::palpation
