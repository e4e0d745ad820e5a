#include "applications/scene_settings.h"

#include <algorithm>

namespace palpate::applications {

scene::SceneDescription scene_settings(const sim::config::WorldFile& world, const std::string& application) {
  scene::SceneDescription scene;
  scene.application = application;
  scene.gravity = world.gravity;
  scene.ball_radius = world.ball.radius;
  scene.ball_mass = world.ball.mass;
  scene.bat_radius = world.scene.bat_radius;
  if (world.scene.bat_mass > 0.0) scene.bat_mass = world.scene.bat_mass;
  scene.bat_offset = application == "touch" ? Vector3(Vector3::Zero()) : world.scene.bat_offset;  // no bat
  scene.bat_restitution = world.ball.restitution_bat;
  scene.contact_s = world.ball.contact_s;
  scene.serve_speed = world.ball.serve_speed;
  scene.physics = world.ball.physics == "paper" ? scene::Physics::paper : scene::Physics::full;
  scene.contact_model = world.ball.contact == "paper"           ? scene::ContactModel::paper
                        : world.ball.contact == "hunt-crossley" ? scene::ContactModel::hunt_crossley
                                                                : scene::ContactModel::non_sticky;
  if (application == "touch")
    scene.bodies = {{"Organ", 0.0}, {"Stylus", 0.0}};
  else
    scene.bodies = {{"Ball", scene.ball_mass}, {"Bat", world.scene.bat_mass}};
  const auto& touch = world.touch;
  scene.touched = {.mesh_file = application == "touch" ? touch.mesh : "",
                   .metres_per_unit = touch.scale * (touch.unit == "m" ? 1.0 : 1e-3),
                   .turn = touch.turn,
                   .shift = touch.shift,
                   .stiffness = touch.stiffness,
                   .damping = touch.damping,
                   .static_friction = touch.static_friction,
                   .friction = touch.friction};
  return scene;
}

void ease_for_a_person(sim::config::WorldFile& world) {
  auto& serve = world.ball.serve_speed;
  serve[1] = std::min(serve[1], std::max(2.3, serve[0]));
}

}  // namespace palpate::applications
