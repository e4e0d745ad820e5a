// The applications there are: by name, what each puts on the physics side and on the graphics side.
#pragma once

#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "palpate/core/expected.h"
#include "palpate/scene/application.h"

namespace palpate {

struct ApplicationInfo {
  std::string name, summary;
  bool scripted_player = false;  // one that plays the demo in a person's place
};
const std::vector<ApplicationInfo>& applications();

// Wrong use for an unknown name, refused where nobody but a person can play it; `whose` begins the message.
Expected<void> needs_scripted_player(const std::string& name, std::string_view whose);

// Wrong use for an unknown name, refused where the scene lacks what the application needs.
Expected<std::unique_ptr<Application>> make_application(const SceneDescription& scene, std::uint64_t seed);
Expected<std::unique_ptr<Artist>> make_artist(const SceneDescription& scene);

}  // namespace palpate
