// For tests of applications: a scene with the reference laboratory's table, and one with another setting.
#pragma once

#include <string>
#include <string_view>
#include <utility>

#include "palpate/scene/application.h"
#include "palpate/scene/setting_schema.h"

namespace palpate::scene {

// What the application itself says of the scene is not in it.
inline SceneDescription table_for_tests(std::string application) {
  SceneDescription scene;
  scene.application = std::move(application);
  scene.surfaces = {{"table",
                     {Vector3(-0.375, -1.52, 1.80), Vector3(0.375, -1.52, 1.80), Vector3(0.375, -1.52, 0.80),
                      Vector3(-0.375, -1.52, 0.80)}}};
  return scene;
}

// The same scene with one setting changed, by its name and in its unit.
inline SceneDescription with_setting(const SettingSchema& schema, SceneDescription scene,
                                     std::string_view name, SettingValue value) {
  auto values = from_payload(schema, scene.settings).value();
  values.set(name, std::move(value));
  scene.settings = to_payload(schema, values);
  return scene;
}

}  // namespace palpate::scene
