// For tests: the reference laboratory's table, and palpation on it.
#pragma once

#include <string_view>
#include <utility>
#include <vector>

#include "applications/palpation/settings.h"
#include "palpate/scene/application.h"

namespace palpate::applications::palpation {

inline scene::SceneDescription table_for_tests() {
  scene::SceneDescription scene;
  scene.application = "palpation";
  scene.surfaces = {{"table",
                     {Vector3(-0.375, -1.52, 1.80), Vector3(0.375, -1.52, 1.80), Vector3(0.375, -1.52, 0.80),
                      Vector3(-0.375, -1.52, 0.80)}}};
  describe(scene::SettingValues(setting_schema()), scene);
  return scene;
}

// The same scene with one setting changed, by its name and in its unit.
inline scene::SceneDescription with(scene::SceneDescription scene, std::string_view name,
                                    scene::SettingValue value) {
  auto values = scene::from_payload(setting_schema(), scene.settings).value();
  values.set(name, std::move(value));
  scene.settings = scene::to_payload(setting_schema(), values);
  return scene;
}

}  // namespace palpate::applications::palpation
