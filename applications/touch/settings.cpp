#include "applications/touch/settings.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <array>
#include <stdexcept>

#include "applications/touch/looks.h"
#include "applications/touch/touch.h"

namespace palpate::applications::touch {
namespace {

constexpr NumberRange kFrictions{0.0, 2.0};

std::vector<std::string> colour_names() {
  std::vector<std::string> names;
  for (const auto& colour : kColours) names.emplace_back(colour.name);
  return names;
}

std::vector<scene::SettingField> fields() {
  // There the reference arm reaches all round.
  auto all = scene::mesh_fields("touch", "STL, OBJ or PLY file; empty: the organ that is built in",
                                {80.0, 60.0, 40.0}, "plinth");
  for (auto& field :
       {scene::number_field("touch", "stiffness_n_m", 600.0, {1.0, kMostStiffness}, "Along all directions"),
        scene::number_field("touch", "damping_n_s_m", 2.0, {0.0, kMostDamping}, "Along the normal"),
        scene::number_field("touch", "static_friction", 0.4, kFrictions,
                            "Sideways over normal force, until it slides"),
        scene::number_field("touch", "friction", 0.3, kFrictions, "While it slides"),
        scene::choice_field("touch", "colour", std::string(kColours.front().name), colour_names(),
                            "Of the surface in the picture")})
    all.push_back(field);
  return all;
}

std::vector<scene::SettingComplaint> relations(const scene::SettingValues& values) {
  if (values.number("touch.static_friction") >= values.number("touch.friction")) return {};
  return {{"touch", "static_friction", "at least friction is expected"}};
}

struct Material {
  const char* name;
  double stiffness, damping, static_friction, friction;
};
// Bone is as stiff as such an arm renders, which is far softer than bone. Soft tissue: the secant to 3 mm of
// Hertz's sphere of 3 mm on a half-space of 20 kPa. Frictions are set by feel, not measured.
constexpr std::array<Material, 3> kMaterials{{{"plain", 600.0, 2.0, 0.4, 0.3},
                                              {"bone", 800.0, 2.0, 0.3, 0.2},
                                              {"soft-tissue", 110.0, 1.0, 0.2, 0.15}}};

Expected<void> set_material(const std::string& name, scene::SettingValues& values) {
  for (const auto& material : kMaterials)
    if (name == material.name) {
      values.set("touch.stiffness_n_m", material.stiffness);
      values.set("touch.damping_n_s_m", material.damping);
      values.set("touch.static_friction", material.static_friction);
      values.set("touch.friction", material.friction);
    }
  return {};
}

}  // namespace

const scene::SettingSchema& setting_schema() {
  static const scene::SettingSchema schema{fields(), relations};
  return schema;
}

std::vector<scene::ApplicationOption> options() {
  auto all = scene::mesh_options("touch", "STL, OBJ or PLY file to explore instead of the organ");
  all.push_back({.name = "--material",
                 .help = "plain, bone or soft-tissue; the settings of [touch] hold the numbers",
                 .choices = {"plain", "bone", "soft-tissue"},
                 .apply = set_material});
  all.push_back(
      {.name = "--colour",
       .help = "Of the surface in the picture: " + fmt::format("{}", fmt::join(colour_names(), ", ")),
       .choices = colour_names(),
       .apply = [](const std::string& name, scene::SettingValues& values) -> Expected<void> {
         values.set("touch.colour", name);
         return {};
       }});
  return all;
}

SurfaceSettings surface_settings(const scene::SettingValues& values) {
  SurfaceSettings surface{scene::chosen_mesh(values, "touch")};
  surface.stiffness = values.number("touch.stiffness_n_m");
  surface.damping = values.number("touch.damping_n_s_m");
  surface.static_friction = values.number("touch.static_friction");
  surface.friction = values.number("touch.friction");
  surface.colour = values.text("touch.colour");
  return surface;
}

SurfaceSettings surface_settings(const scene::SceneDescription& scene) {
  const auto values = scene::from_payload(setting_schema(), scene.settings);
  if (!values) throw std::invalid_argument("touch: " + values.error().message);
  return surface_settings(*values);
}

void describe(const scene::SettingValues& values, scene::SceneDescription& scene) {
  const SurfaceSettings surface = surface_settings(values);
  scene.carried_offset.setZero();  // the bare stylus
  scene.bodies = {{"Organ", 0.0}, {"Stylus", 0.0}};
  scene::set_mesh(surface, scene);
  scene.settings = scene::to_payload(setting_schema(), values);
}

}  // namespace palpate::applications::touch
