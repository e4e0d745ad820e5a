#include "settings.h"

#include <stdexcept>

namespace jelly {

const palpate::scene::SettingSchema& setting_schema() {
  static const palpate::scene::SettingSchema schema{.fields = {{.section = "jelly",
                                                                .key = "firmness",
                                                                .initial = std::vector<double>{1.0},
                                                                .range = {0.3, 2.5},
                                                                .help = "Times as firm as an ordinary jelly"},
                                                               {.section = "jelly",
                                                                .key = "damping",
                                                                .initial = std::vector<double>{0.10},
                                                                .range = {0.02, 1.0},
                                                                .help = "1: it does not wobble"}},
                                                    .relations = {}};
  return schema;
}

void describe(const palpate::scene::SettingValues& values, palpate::scene::SceneDescription& scene) {
  scene.carried_offset.setZero();  // the bare stylus
  scene.bodies = {{"Jelly", 0.0}, {"Stylus", 0.0}};
  scene.settings = palpate::scene::to_payload(setting_schema(), values);
}

Material material_of(const palpate::scene::SceneDescription& scene) {
  const auto values = palpate::scene::from_payload(setting_schema(), scene.settings);
  if (!values) throw std::invalid_argument(values.error().message);
  return {values->number("jelly.firmness"), values->number("jelly.damping")};
}

}  // namespace jelly
