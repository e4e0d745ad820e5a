// The applications there are: by name, what each puts on the physics side and on the graphics side,
// and its scripted player.
#pragma once

#include <memory>
#include <optional>
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
// `serve_pause_s`: for people: so long a pause lies between two serves, and a rally lasts as long as the ball
// comes back. None: serves follow each other at the demo's pace, and rallies are rationed.
Expected<std::unique_ptr<Application>> make_application(const SceneDescription& scene, std::uint64_t seed,
                                                        std::optional<double> serve_pause_s = {});
Expected<std::unique_ptr<Artist>> make_artist(const SceneDescription& scene);
// One that plays the demo in a person's place.
Expected<std::unique_ptr<Player>> make_player(const SceneDescription& scene, const Reach& reach,
                                              const PlayerSettings& settings);
// Helps a person who plays with the mouse; null where the application has no need of it.
Expected<std::unique_ptr<HandHelp>> make_hand_help(const SceneDescription& scene, const Reach& reach,
                                                   const PlayerSettings& settings);

}  // namespace palpate
