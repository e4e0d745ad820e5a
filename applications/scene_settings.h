// The virtual things of an application (ball, bat, serves) as a world file describes them: settings, not
// truth about the laboratory.
#pragma once

#include <string>

#include "palpate/scene/application.h"
#include "palpate/sim/config/world_file.h"

namespace palpate::applications {

// Everything but the surfaces, which are the rig's.
scene::SceneDescription scene_settings(const sim::config::WorldFile& world, const std::string& application);

// Settings that a person can begin with: slow serves.
void ease_for_a_person(sim::config::WorldFile& world);

}  // namespace palpate::applications
