#include "palpate/scene/shown_tip.h"

namespace palpate::scene {

Vector3 shown_tip(const SceneState& state, const SceneDescription& scene) {
  const auto& carried = state.bodies[kCarried];
  return carried.p() - carried.q() * scene.carried_offset;
}

}  // namespace palpate::scene
