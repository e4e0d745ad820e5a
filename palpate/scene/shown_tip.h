// Where the stylus is, of a state that shows what it carries. World frame, metres; a pure function.
#pragma once

#include "palpate/scene/application.h"

namespace palpate::scene {

// The tip of the stylus as a state shows it: the carried body's pose taken back along its offset.
Vector3 shown_tip(const SceneState& state, const SceneDescription& scene);

}  // namespace palpate::scene
