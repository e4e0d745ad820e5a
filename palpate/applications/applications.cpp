#include "palpate/applications/applications.h"

#include "palpate/applications/pingpong/artist.h"
#include "palpate/applications/pingpong/pingpong.h"
#include "palpate/applications/pingpong/player.h"
#include "palpate/applications/pingpong/stroke_help.h"
#include "palpate/applications/touch/artist.h"
#include "palpate/applications/touch/explorer.h"
#include "palpate/applications/touch/touch.h"

namespace palpate {

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

Expected<void> has_surface(const SceneDescription& scene, std::string_view name) {
  for (const auto& surface : scene.surfaces)
    if (surface.name == name) return {};
  return refused("{}: the rig has no calibrated surface '{}'; run `palpate calibrate surface`",
                 scene.application, name);
}

Expected<void> ready(const SceneDescription& scene) {
  if (auto ok = known(scene.application); !ok) return ok;
  if (auto ok = has_surface(scene, "table"); !ok) return ok;
  return scene.application == "pingpong" ? has_surface(scene, "wall") : Expected<void>{};
}

}  // namespace

Expected<std::unique_ptr<Application>> make_application(const SceneDescription& scene, std::uint64_t seed,
                                                        std::optional<double> serve_pause_s) {
  if (auto ok = ready(scene); !ok) return tl::unexpected(ok.error());
  if (scene.application == "touch") return std::make_unique<touch::Touch>(scene);
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

Expected<std::unique_ptr<Artist>> make_artist(const SceneDescription& scene) {
  if (auto ok = ready(scene); !ok) return tl::unexpected(ok.error());
  if (scene.application == "touch") return std::make_unique<touch::TouchArtist>(scene);
  return std::make_unique<pingpong::PingPongArtist>(scene);
}

Expected<std::unique_ptr<Player>> make_player(const SceneDescription& scene, const Reach& reach,
                                              const PlayerSettings& settings) {
  if (auto ok = ready(scene); !ok) return tl::unexpected(ok.error());
  if (scene.application == "touch") return std::make_unique<touch::Explorer>(scene, reach, settings);
  return std::make_unique<pingpong::ScriptedPlayer>(scene, reach, settings);
}

Expected<std::unique_ptr<HandHelp>> make_hand_help(const SceneDescription& scene, const Reach& reach,
                                                   const PlayerSettings& settings) {
  if (auto ok = ready(scene); !ok) return tl::unexpected(ok.error());
  if (scene.application == "touch") return nullptr;
  return std::make_unique<pingpong::StrokeHelp>(scene, reach, settings);
}

}  // namespace palpate
