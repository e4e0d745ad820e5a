// The applications there are: by name, what each puts on the physics side and on the graphics side,
// and its scripted player.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "palpate/core/expected.h"
#include "palpate/devices/player.h"
#include "palpate/scene/application.h"

namespace palpate {

struct ApplicationInfo {
  std::string name, summary;
};
const std::vector<ApplicationInfo>& applications();

// Wrong use for an unknown name, refused where the scene lacks what the application needs.
Expected<std::unique_ptr<Application>> make_application(const SceneDescription& scene, std::uint64_t seed);
Expected<std::unique_ptr<Artist>> make_artist(const SceneDescription& scene);
// One that plays the demo in a person's place.
Expected<std::unique_ptr<Player>> make_player(const SceneDescription& scene, const Reach& reach,
                                              const PlayerSettings& settings);

}  // namespace palpate
