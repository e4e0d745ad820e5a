#include "palpate/scene/shown_tip.h"

namespace palpate::scene {

Vector3 shown_tip(const SceneState& state, const SceneDescription& scene) {
  const auto& bat = state.bodies[kCarried];
  return bat.p() - bat.q() * scene.bat_offset;
}

}  // namespace palpate::scene
