// Whether both servers' rigs say the same of the real surfaces: else forces and pictures are in different places.
#pragma once

#include <string>

#include "palpate/core/expected.h"
#include "palpate/rig/rig.h"
#include "palpate/scene/application.h"

namespace palpate::server::session {

// At the first meeting with the physics server at `address`: refused where a surface lies more than
// SurfaceComparison::kElsewhere from where `rig` has it; told to the log where one lies elsewhere at all, or is
// missing on either side. Says nothing where all lie in the same places.
Expected<void> same_places(const rig::Rig& rig, const scene::SceneDescription& scene,
                           const std::string& address);

}  // namespace palpate::server::session
