// For tests: the reference laboratory's table, and the organ on it in fewer triangles.
#pragma once

#include <memory>

#include "applications/touch/organ.h"
#include "palpate/scene/application.h"

namespace palpate::applications::touch {

inline scene::SceneDescription table_for_tests() {
  scene::SceneDescription scene;
  scene.application = "touch";
  scene.surfaces = {{"table",
                     {Vector3(-0.375, -1.52, 1.80), Vector3(0.375, -1.52, 1.80), Vector3(0.375, -1.52, 0.80),
                      Vector3(-0.375, -1.52, 0.80)},
                     0.93}};
  scene.bat_offset.setZero();
  return scene;
}

// As a mesh that a person brings.
inline scene::SceneDescription organ_on_table() {
  scene::SceneDescription scene = table_for_tests();
  static const auto organ = std::make_shared<scene::TriangleMesh>(organ_mesh(40));
  scene.touched.mesh = organ;
  return scene;
}

}  // namespace palpate::applications::touch
