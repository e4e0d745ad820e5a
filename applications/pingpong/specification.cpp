#include "applications/pingpong/specification.h"

#include "applications/pingpong/pingpong.h"
#include "applications/pingpong/player.h"
#include "applications/pingpong/record.h"
#include "applications/pingpong/scene_view.h"
#include "applications/pingpong/settings.h"
#include "applications/pingpong/stroke_assist.h"

namespace palpate::applications::pingpong {
namespace {

Settings settings_of(const scene::RunSettings& run) {
  Settings settings;
  settings.seed = run.seed;
  if (!run.pause_s) return settings;
  settings.pace_s = 0.0;
  settings.pause_s = *run.pause_s;
  settings.ready_s = 0.6;  // a person wants to see where the ball will come from
  settings.first_serve_s = 2.0;
  return settings;
}

}  // namespace

scene::ApplicationSpec specification() {
  scene::ApplicationSpec spec;
  spec.name = "pingpong";
  spec.summary = "Return a virtual ball over a real table to a real wall, with a bat you feel";
  spec.surfaces = {"table", "wall"};
  spec.handling = {.held = "bat",
                   .plays = "play",
                   .faces = "wall",
                   .buttons = "turn the bat, send the ball aside",
                   .begins = "serve"};
  spec.settings = setting_schema();
  spec.describe = describe;
  spec.ease_for_a_person = ease_for_a_person;
  spec.make_physics = [](const scene::SceneDescription& scene, const scene::RunSettings& run) {
    return std::make_unique<PingPong>(scene, settings_of(run));
  };
  spec.make_view = [](const scene::SceneDescription& scene) { return std::make_unique<PingPongView>(scene); };
  spec.make_player = [](const scene::SceneDescription& scene, const scene::Reach& reach,
                        const scene::PlayerSettings& settings) {
    return std::make_unique<ScriptedPlayer>(scene, reach, settings);
  };
  spec.make_input_assist = [](const scene::SceneDescription& scene, const scene::Reach& reach,
                              const scene::PlayerSettings& settings) {
    return std::make_unique<StrokeAssist>(scene, reach, settings);
  };
  add_record(spec);
  return spec;
}

}  // namespace palpate::applications::pingpong
