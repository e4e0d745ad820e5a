// The virtual things of an application (ball, bat, serves) as a world file describes them: settings, not
// truth about the laboratory.
#pragma once

#include <string>

#include "palpate/model/world_file.h"
#include "palpate/scene/application.h"

namespace palpate {

// Everything but the surfaces, which are the rig's.
SceneDescription scene_settings(const sim::WorldFile& world, const std::string& application);

}  // namespace palpate
