#include "tools/commands/touch_options.h"

#include <fmt/format.h>

#include <array>
#include <filesystem>

namespace palpate::tools::commands {
namespace {

struct TouchMaterial {
  const char* name;
  double stiffness, damping, static_friction, friction;
};
// Bone is as stiff as such an arm renders, which is far softer than bone. Soft tissue: the secant to 3 mm of
// Hertz's sphere of 3 mm on a half-space of 20 kPa. Frictions are set by feel, not measured.
constexpr std::array<TouchMaterial, 3> kTouchMaterials{{{"plain", 600.0, 2.0, 0.4, 0.3},
                                                        {"bone", 800.0, 2.0, 0.3, 0.2},
                                                        {"soft-tissue", 110.0, 1.0, 0.2, 0.15}}};

}  // namespace

void add_touch_options(CLI::App& command, TouchOptions& options) {
  command.add_option("--mesh", options.mesh,
                     "With --app touch: STL, OBJ or PLY file to explore instead of the organ");
  command.add_option("--unit", options.unit, "Unit of that file's lengths: mm (default) or m")
      ->check(CLI::IsMember({"mm", "m"}));
  command
      .add_option("--material", options.material,
                  "With --app touch: plain, bone or soft-tissue; the world file's [touch] holds the numbers")
      ->check(CLI::IsMember({"plain", "bone", "soft-tissue"}));
}

Expected<void> apply(const TouchOptions& options, const std::string& application,
                     sim::config::WorldFile& world) {
  for (const auto& [name, value] :
       {std::pair{"--mesh", &options.mesh}, {"--unit", &options.unit}, {"--material", &options.material}})
    if (!value->empty() && application != "touch")
      return wrong_use("{} {}: {} touches nothing; --app touch does", name, *value, application);
  if (!options.mesh.empty())
    world.touch.mesh = std::filesystem::absolute(options.mesh).lexically_normal().string();
  if (!options.unit.empty()) {
    if (world.touch.mesh.empty())
      return wrong_use("--unit {}: no mesh is named; say which with --mesh FILE", options.unit);
    world.touch.unit = options.unit;
  }
  for (const auto& material : kTouchMaterials)
    if (options.material == material.name) {
      world.touch.stiffness = material.stiffness;
      world.touch.damping = material.damping;
      world.touch.static_friction = material.static_friction;
      world.touch.friction = material.friction;
    }
  return {};
}

std::string typed(const TouchOptions& options) {
  std::string line;
  for (const auto& [name, value] :
       {std::pair{"--mesh", &options.mesh}, {"--unit", &options.unit}, {"--material", &options.material}})
    if (!value->empty()) line += fmt::format(" {} {}", name, *value);
  return line;
}

}  // namespace palpate::tools::commands
