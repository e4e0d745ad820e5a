#include "applications/applications.h"

#include "applications/pingpong/pingpong.h"
#include "applications/pingpong/player.h"
#include "applications/pingpong/scene_view.h"
#include "applications/pingpong/stroke_assist.h"
#include "applications/touch/explorer.h"
#include "applications/touch/scene_view.h"
#include "applications/touch/touch.h"

namespace palpate::applications {

const std::vector<ApplicationInfo>& applications() {
  static const std::vector<ApplicationInfo> list = {
      {"pingpong", "Return a virtual ball over a real table to a real wall, with a bat you feel"},
      {"touch",
       "Explore a virtual organ, or a mesh of your own, on a real table with the tip of the stylus"}};
  return list;
}

namespace {

Expected<void> known(const std::string& name) {
  std::string names;
  for (const auto& application : applications()) {
    if (application.name == name) return {};
    names += (names.empty() ? "" : ", ") + application.name;
  }
  return wrong_use("application '{}' is not known; there are: {}", name, names);
}

Expected<void> has_surface(const scene::SceneDescription& scene, std::string_view name) {
  for (const auto& surface : scene.surfaces)
    if (surface.name == name) return {};
  return refused("{}: the rig has no calibrated surface '{}'; run `palpate calibrate surface`",
                 scene.application, name);
}

Expected<void> ready(const scene::SceneDescription& scene) {
  if (auto ok = known(scene.application); !ok) return ok;
  if (auto ok = has_surface(scene, "table"); !ok) return ok;
  return scene.application == "pingpong" ? has_surface(scene, "wall") : Expected<void>{};
}

}  // namespace

Expected<std::unique_ptr<scene::Application>> make_application(const scene::SceneDescription& scene,
                                                               std::uint64_t seed,
                                                               std::optional<double> serve_pause_s) {
  if (auto ok = ready(scene); !ok) return tl::unexpected(ok.error());
  if (scene.application == "touch") return std::make_unique<touch::TouchApplication>(scene);
  pingpong::Settings settings;
  settings.seed = seed;
  if (serve_pause_s) {
    settings.pace_s = 0.0;
    settings.pause_s = *serve_pause_s;
    settings.ready_s = 0.6;  // a person wants to see where the ball will come from
    settings.first_serve_s = 2.0;
  }
  return std::make_unique<pingpong::PingPong>(scene, settings);
}

Expected<std::unique_ptr<scene::SceneView>> make_scene_view(const scene::SceneDescription& scene) {
  if (auto ok = ready(scene); !ok) return tl::unexpected(ok.error());
  if (scene.application == "touch") return std::make_unique<touch::TouchView>(scene);
  return std::make_unique<pingpong::PingPongView>(scene);
}

Expected<std::unique_ptr<scene::Player>> make_player(const scene::SceneDescription& scene,
                                                     const scene::Reach& reach,
                                                     const scene::PlayerSettings& settings) {
  if (auto ok = ready(scene); !ok) return tl::unexpected(ok.error());
  if (scene.application == "touch") return std::make_unique<touch::Explorer>(scene, reach, settings);
  return std::make_unique<pingpong::ScriptedPlayer>(scene, reach, settings);
}

Expected<std::unique_ptr<scene::InputAssist>> make_input_assist(const scene::SceneDescription& scene,
                                                                const scene::Reach& reach,
                                                                const scene::PlayerSettings& settings) {
  if (auto ok = ready(scene); !ok) return tl::unexpected(ok.error());
  if (scene.application == "touch") return nullptr;
  return std::make_unique<pingpong::StrokeAssist>(scene, reach, settings);
}

}  // namespace palpate::applications
