// The scene of an application in a laboratory. Pure function.
#pragma once

#include <string_view>

#include "palpate/sim/config/world_file.h"

namespace palpate::sim::config {

// What the application describes with the world's settings, under the world's gravity; surfaces are the rig's.
// Errors: as ApplicationRegistry::describe().
inline Expected<scene::SceneDescription> scene_of(const WorldFile& world,
                                                  const scene::ApplicationRegistry& applications,
                                                  std::string_view application) {
  auto scene = applications.describe(application, world.settings);
  if (scene) scene->gravity = world.gravity;
  return scene;
}

}  // namespace palpate::sim::config
