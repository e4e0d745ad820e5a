// The scene in which the tests of ping-pong play: a small table, a wall, a right-handed player's arm. For
// tests only.
#pragma once

#include "palpate/scene/application.h"

namespace palpate::applications::pingpong {

inline scene::SceneDescription scene_for_tests() {
  scene::SceneDescription scene;
  scene.application = "pingpong";
  scene.surfaces = {{"table",
                     {Vector3(-0.375, -1.52, 1.80), Vector3(0.375, -1.52, 1.80), Vector3(0.375, -1.52, 0.80),
                      Vector3(-0.375, -1.52, 0.80)},
                     0.93},
                    {"wall",
                     {Vector3(-0.375, -1.52, 0.80), Vector3(0.375, -1.52, 0.80), Vector3(0.375, -0.92, 0.80),
                      Vector3(-0.375, -0.92, 0.80)},
                     0.93}};
  return scene;
}

inline scene::SceneDescription with(scene::SceneDescription scene, scene::Physics physics,
                                    scene::ContactModel contact = scene::ContactModel::non_sticky) {
  scene.physics = physics;
  scene.contact_model = contact;
  return scene;
}

}  // namespace palpate::applications::pingpong
