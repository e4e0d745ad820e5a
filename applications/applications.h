// The applications there are: by name, what each puts on the physics side and on the graphics side,
// and its scripted player.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "palpate/core/expected.h"
#include "palpate/scene/application.h"
#include "palpate/scene/player.h"

namespace palpate::applications {

struct ApplicationInfo {
  std::string name, summary;
};
const std::vector<ApplicationInfo>& applications();

// Wrong use for an unknown name, refused where the scene lacks what the application needs.
// `serve_pause_s`: for people: so long a pause lies between two serves, and a rally lasts as long as the ball
// comes back. None: serves follow each other at the demo's pace, and rallies are rationed.
Expected<std::unique_ptr<scene::Application>> make_application(const scene::SceneDescription& scene,
                                                               std::uint64_t seed,
                                                               std::optional<double> serve_pause_s = {});
Expected<std::unique_ptr<scene::SceneView>> make_scene_view(const scene::SceneDescription& scene);
// One that plays the demo in a person's place.
Expected<std::unique_ptr<scene::Player>> make_player(const scene::SceneDescription& scene,
                                                     const scene::Reach& reach,
                                                     const scene::PlayerSettings& settings);
// Helps a person who plays with the mouse; null where the application has no need of it.
Expected<std::unique_ptr<scene::InputAssist>> make_input_assist(const scene::SceneDescription& scene,
                                                                const scene::Reach& reach,
                                                                const scene::PlayerSettings& settings);

}  // namespace palpate::applications
