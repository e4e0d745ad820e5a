#include "applications/palpation/specification.h"

#include "applications/palpation/example.h"
#include "applications/palpation/learning_study.h"
#include "applications/palpation/liver.h"
#include "applications/palpation/palpation.h"
#include "applications/palpation/palpation_study.h"
#include "applications/palpation/record.h"
#include "applications/palpation/scene_view.h"
#include "applications/palpation/settings.h"
#include "applications/palpation/trainee.h"

namespace palpate::applications::palpation {

scene::ApplicationSpec specification() {
  scene::ApplicationSpec spec;
  spec.name = "palpation";
  spec.summary = "Press a soft organ on a real table and find what is hard inside it";
  spec.surfaces = {"table"};
  spec.handling = {.plays = "search", .begins = "mark, or the next trial"};
  spec.settings = setting_schema();
  spec.describe = describe;
  spec.options = options();
  spec.make_physics = [](const scene::SceneDescription& scene, const scene::RunSettings& run) {
    return std::make_unique<PalpationApplication>(scene, run, cache_folder());
  };
  spec.make_view = [](const scene::SceneDescription& scene) {
    return std::make_unique<PalpationView>(scene);
  };
  spec.make_player = [](const scene::SceneDescription& scene, const scene::Reach& reach,
                        const scene::PlayerSettings& settings) {
    return std::make_unique<Trainee>(scene, reach, settings);
  };
  spec.explored = explored_surface;
  add_record(spec);
  spec.example_state = example_state;
  spec.example_shape = example_shape;
  spec.quick_demo_s = 24.0;
  spec.shorten_for_a_quick_demo = shorten_for_a_quick_demo;
  spec.studies = {palpation_study(), learning_study()};
  return spec;
}

}  // namespace palpate::applications::palpation
