#include "applications/touch/settings.h"

#include <array>
#include <filesystem>
#include <stdexcept>

#include "applications/touch/touch.h"
#include "palpate/core/units.h"

namespace palpate::applications::touch {
namespace {

constexpr double kMm = 1e-3, kDeg = 1.0 / kDegreesPerRadian;
constexpr NumberRange kFrictions{0.0, 2.0};

using scene::SettingKind;

std::vector<scene::SettingField> fields() {
  const auto number = [](std::string key, double initial, NumberRange range, std::string help) {
    return scene::SettingField{.section = "touch",
                               .key = std::move(key),
                               .initial = std::vector<double>{initial},
                               .range = range,
                               .help = std::move(help)};
  };
  return {{.section = "touch",
           .key = "mesh",
           .kind = SettingKind::file,
           .initial = "",
           .help = "STL, OBJ or PLY file; empty: the organ that is built in"},
          {.section = "touch",
           .key = "unit",
           .kind = SettingKind::choice,
           .initial = "mm",
           .choices = {"mm", "m"},
           .help = "Of the file's lengths"},
          number("scale", 1.0, {1e-6, 1e6}, "How many times larger it is felt"),
          {.section = "touch",
           .key = "turn_deg",
           .kind = SettingKind::numbers,
           .initial = std::vector<double>{0.0, 0.0, 0.0},
           .unit = kDeg,
           .help = "Angles about x, y, z; y is up afterwards"},
          {.section = "touch",
           .key = "shift_mm",
           .kind = SettingKind::numbers,
           .initial = std::vector<double>{80.0, 60.0, 40.0},
           .unit = kMm,
           .help = "On the table: to the right, up on a plinth, towards the user"},
          number("stiffness_n_m", 600.0, {1.0, kMostStiffness}, "Along all directions"),
          number("damping_n_s_m", 2.0, {0.0, kMostDamping}, "Along the normal"),
          number("static_friction", 0.4, kFrictions, "Sideways over normal force, until it slides"),
          number("friction", 0.3, kFrictions, "While it slides")};
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

Expected<void> set_mesh(const std::string& file, scene::SettingValues& values) {
  values.set("touch.mesh", std::filesystem::absolute(file).lexically_normal().string());
  return {};
}

Expected<void> set_unit(const std::string& unit, scene::SettingValues& values) {
  if (values.text("touch.mesh").empty())
    return wrong_use("--unit {}: no mesh is named; say which with --mesh FILE", unit);
  values.set("touch.unit", unit);
  return {};
}

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
  return {
      {.name = "--mesh", .help = "STL, OBJ or PLY file to explore instead of the organ", .apply = set_mesh},
      {.name = "--unit",
       .help = "Unit of that file's lengths: mm (default) or m",
       .choices = {"mm", "m"},
       .apply = set_unit},
      {.name = "--material",
       .help = "plain, bone or soft-tissue; the settings of [touch] hold the numbers",
       .choices = {"plain", "bone", "soft-tissue"},
       .apply = set_material}};
}

SurfaceSettings surface_settings(const scene::SettingValues& values) {
  SurfaceSettings surface;
  surface.mesh_file = values.text("touch.mesh");
  surface.metres_per_unit = values.number("touch.scale") * (values.text("touch.unit") == "m" ? 1.0 : kMm);
  surface.turn = values.vector("touch.turn_deg");
  surface.shift = values.vector("touch.shift_mm");
  surface.stiffness = values.number("touch.stiffness_n_m");
  surface.damping = values.number("touch.damping_n_s_m");
  surface.static_friction = values.number("touch.static_friction");
  surface.friction = values.number("touch.friction");
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
  scene.mesh.reset();
  if (!surface.mesh_file.empty())
    scene.mesh = scene::MeshAsset{.file = surface.mesh_file, .metres_per_unit = surface.metres_per_unit};
  scene.settings = scene::to_payload(setting_schema(), values);
}

}  // namespace palpate::applications::touch
