#include "specification.h"

#include "application.h"
#include "prodder.h"
#include "record.h"
#include "settings.h"
#include "view.h"

namespace jelly {

using namespace palpate;

scene::ApplicationSpec specification() {
  scene::ApplicationSpec spec;
  spec.name = "jelly";
  spec.summary = "Press into a jelly with the tip of the stylus, and let it wobble";
  spec.surfaces = {"table"};
  spec.handling = {.plays = "prod", .begins = "wobble"};
  spec.settings = setting_schema();
  spec.describe = describe;
  spec.make_physics = [](const scene::SceneDescription& scene, const scene::RunSettings&) {
    return std::make_unique<JellyApplication>(scene);
  };
  spec.make_view = [](const scene::SceneDescription& scene) { return std::make_unique<JellyView>(scene); };
  spec.make_player = [](const scene::SceneDescription& scene, const scene::Reach& reach,
                        const scene::PlayerSettings& settings) {
    return std::make_unique<Prodder>(scene, reach, settings);
  };
  spec.tables = {{kTable, "the jelly, millisecond by millisecond"}};
  spec.make_record = [](const scene::SceneDescription&) { return std::make_unique<JellyRecord>(); };
  spec.report = report_of;
  return spec;
}

}  // namespace jelly
