#include "applications/touch/specification.h"

#include "applications/touch/explorer.h"
#include "applications/touch/organ.h"
#include "applications/touch/record.h"
#include "applications/touch/scene_view.h"
#include "applications/touch/settings.h"
#include "applications/touch/touch.h"

namespace palpate::applications::touch {

scene::ApplicationSpec specification() {
  scene::ApplicationSpec spec;
  spec.name = "touch";
  spec.summary = "Explore a virtual organ, or a mesh of your own, on a real table with the tip of the stylus";
  spec.surfaces = {"table"};
  spec.handling = {.plays = "touch"};
  spec.settings = setting_schema();
  spec.describe = describe;
  spec.options = options();
  spec.make_physics = [](const scene::SceneDescription& scene, const scene::RunSettings&) {
    return std::make_unique<TouchApplication>(scene);
  };
  spec.make_view = [](const scene::SceneDescription& scene) { return std::make_unique<TouchView>(scene); };
  spec.make_player = [](const scene::SceneDescription& scene, const scene::Reach& reach,
                        const scene::PlayerSettings& settings) {
    return std::make_unique<Explorer>(scene, reach, settings);
  };
  spec.explored = explored_surface;
  add_record(spec);
  return spec;
}

}  // namespace palpate::applications::touch
