// The scene in which the tests of ping-pong play: a small table, a wall, a right-handed player's arm. For
// tests only.
#pragma once

#include <string_view>
#include <utility>
#include <vector>

#include "applications/pingpong/settings.h"
#include "palpate/scene/table_for_tests.h"

namespace palpate::applications::pingpong {

inline scene::SceneDescription scene_for_tests() {
  scene::SceneDescription scene = scene::table_for_tests("pingpong");
  scene.surfaces.push_back({"wall",
                            {Vector3(-0.375, -1.52, 0.80), Vector3(0.375, -1.52, 0.80),
                             Vector3(0.375, -0.92, 0.80), Vector3(-0.375, -0.92, 0.80)}});
  describe(scene::SettingValues(setting_schema()), scene);
  return scene;
}

// The same scene with one setting changed, by its name and in its unit.
inline scene::SceneDescription with(scene::SceneDescription scene, std::string_view name,
                                    scene::SettingValue value) {
  auto values = scene::from_payload(setting_schema(), scene.settings).value();
  values.set(name, std::move(value));
  describe(values, scene);
  return scene;
}

inline scene::SceneDescription with(const scene::SceneDescription& scene, std::string_view name,
                                    double value) {
  return with(scene, name, std::vector<double>{value});
}

inline scene::SceneDescription with(const scene::SceneDescription& scene, Flight flight) {
  return with(scene, "ball.physics", flight == Flight::paper ? "paper" : "full");
}

inline scene::SceneDescription with(const scene::SceneDescription& scene, Flight flight,
                                    scene::ContactModel contact) {
  return with(with(scene, flight), "ball.contact",
              contact == scene::ContactModel::paper           ? "paper"
              : contact == scene::ContactModel::hunt_crossley ? "hunt-crossley"
                                                              : "non-sticky");
}

}  // namespace palpate::applications::pingpong
