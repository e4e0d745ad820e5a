// For tests: the reference laboratory's table, and palpation on it.
#pragma once

#include <string_view>
#include <utility>
#include <vector>

#include "applications/palpation/settings.h"
#include "palpate/scene/table_for_tests.h"

namespace palpate::applications::palpation {

inline scene::SceneDescription table_for_tests() {
  scene::SceneDescription scene = scene::table_for_tests("palpation");
  describe(scene::SettingValues(setting_schema()), scene);
  return scene;
}

// The same scene with one setting changed, by its name and in its unit.
inline scene::SceneDescription with(scene::SceneDescription scene, std::string_view name,
                                    scene::SettingValue value) {
  return scene::with_setting(setting_schema(), std::move(scene), name, std::move(value));
}

}  // namespace palpate::applications::palpation
