// For tests: the reference laboratory's table, and the organ on it in fewer triangles.
#pragma once

#include <memory>
#include <string_view>
#include <utility>
#include <vector>

#include "applications/touch/organ.h"
#include "applications/touch/settings.h"
#include "palpate/scene/table_for_tests.h"

namespace palpate::applications::touch {

inline scene::SceneDescription table_for_tests() {
  scene::SceneDescription scene = scene::table_for_tests("touch");
  describe(scene::SettingValues(setting_schema()), scene);
  return scene;
}

// The same scene with one setting changed, by its name and in its unit.
inline scene::SceneDescription with(scene::SceneDescription scene, std::string_view name,
                                    scene::SettingValue value) {
  return scene::with_setting(setting_schema(), std::move(scene), name, std::move(value));
}

inline scene::SceneDescription with(const scene::SceneDescription& scene, std::string_view name,
                                    double value) {
  return with(scene, name, std::vector<double>{value});
}

// As a mesh that a person brings.
inline scene::SceneDescription organ_on_table() {
  scene::SceneDescription scene = table_for_tests();
  static const auto organ = std::make_shared<scene::TriangleMesh>(organ_mesh(40));
  scene.mesh = scene::MeshAsset{.mesh = organ};
  return scene;
}

}  // namespace palpate::applications::touch
