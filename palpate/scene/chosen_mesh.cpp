#include "palpate/scene/chosen_mesh.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <filesystem>
#include <optional>
#include <utility>

#include "palpate/core/text.h"
#include "palpate/core/units.h"

namespace palpate::scene {
namespace {

constexpr double kMillimetre = 1e-3;
constexpr double kLargestTurn_deg = 360.0;

// "-90,0,0"
std::optional<SettingValue> three_angles(const std::string& text) {
  std::vector<double> angles;
  for (std::size_t at = 0; at <= text.size();) {
    const std::size_t comma = std::min(text.find(',', at), text.size());
    double angle = 0.0;
    const auto [end, failed] = std::from_chars(text.data() + at, text.data() + comma, angle);
    if (failed != std::errc() || end != text.data() + comma || !(std::abs(angle) <= kLargestTurn_deg))
      return std::nullopt;
    angles.push_back(angle);
    at = comma + 1;
  }
  return angles.size() == 3 ? std::optional<SettingValue>(std::move(angles)) : std::nullopt;
}

SettingField three_numbers(const std::string& section, std::string key, const Vector3& initial, double unit,
                           double most, std::string help) {
  return numbers_field(section, std::move(key), {initial.begin(), initial.end()}, {-most, most},
                       std::move(help), unit);
}

}  // namespace

std::vector<SettingField> mesh_fields(const std::string& section, const std::string& help,
                                      const Vector3& shift_mm, const std::string& on) {
  return {{.section = section, .key = "mesh", .kind = SettingKind::file, .initial = "", .help = help},
          choice_field(section, "unit", "mm", {"mm", "m"}, "Of the file's lengths"),
          number_field(section, "scale", 1.0, {1e-6, 1e6}, "How many times larger it is felt"),
          three_numbers(section, "turn_deg", Vector3::Zero(), 1.0 / kDegreesPerRadian, kLargestTurn_deg,
                        "Angles about x, y, z; y is up afterwards"),
          three_numbers(section, "shift_mm", shift_mm, kMillimetre, 1000.0,
                        "On the table: to the right, up on a " + on + ", towards the user")};
}

std::vector<ApplicationOption> mesh_options(const std::string& section, const std::string& help) {
  const auto set_file = [section](const std::string& file, SettingValues& values) -> Expected<void> {
    values.set(section + ".mesh", std::filesystem::absolute(file).lexically_normal().string());
    return {};
  };
  const auto set_unit = [section](const std::string& unit, SettingValues& values) -> Expected<void> {
    if (values.text(section + ".mesh").empty())
      return wrong_use("--unit {}: no mesh is named; say which with --mesh FILE", unit);
    values.set(section + ".unit", unit);
    return {};
  };
  const auto set_turn = [section](const std::string& angles, SettingValues& values) -> Expected<void> {
    if (values.text(section + ".mesh").empty())
      return wrong_use("--turn-deg {}: no mesh is named; say which with --mesh FILE", excerpt(angles));
    const auto turn = three_angles(angles);
    if (!turn)
      return wrong_use(
          "--turn-deg {}: three angles from -{} to {} are expected, such as -90,0,0 for a file whose z is up",
          excerpt(angles), kLargestTurn_deg, kLargestTurn_deg);
    values.set(section + ".turn_deg", *turn);
    return {};
  };
  return {{.name = "--mesh", .help = help, .apply = set_file},
          {.name = "--unit",
           .help = "Unit of that file's lengths: mm (default) or m",
           .choices = {"mm", "m"},
           .apply = set_unit},
          {.name = "--turn-deg",
           .help = "X,Y,Z: turn it about these axes, y is up afterwards; -90,0,0 where the file's z is",
           .apply = set_turn}};
}

ChosenMesh chosen_mesh(const SettingValues& values, const std::string& section) {
  const bool metres = values.text(section + ".unit") == "m";
  return {values.text(section + ".mesh"), values.number(section + ".scale") * (metres ? 1.0 : kMillimetre),
          values.vector(section + ".turn_deg"), values.vector(section + ".shift_mm")};
}

void set_mesh(const ChosenMesh& chosen, SceneDescription& scene) {
  scene.mesh.reset();
  if (!chosen.mesh_file.empty())
    scene.mesh = MeshAsset{.file = chosen.mesh_file, .metres_per_unit = chosen.metres_per_unit};
}

}  // namespace palpate::scene
