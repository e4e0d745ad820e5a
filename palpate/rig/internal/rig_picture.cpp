#include "palpate/rig/internal/rig_picture.h"

#include <fmt/format.h>

#include <set>

#include "palpate/core/units.h"
#include "palpate/rig/internal/number_text.h"

namespace palpate::rig {
namespace {

constexpr double kMetre = 1.0 / kMillimetresPerMetre;
constexpr NumberRange kNear{-1e5, 1e5};  // mm
const std::vector<std::string> kEncodings = {"root", "srgb", "linear"}, kUnits = {"mm", "m"};

std::optional<device::RoomLight> light_of(const TomlTable& table) {
  if (!table.exists()) return std::nullopt;
  device::RoomLight light;
  const auto lamp = table.numbers<3>("lamp_mm", kNear);
  light.lamp = kMetre * Vector3(lamp[0], lamp[1], lamp[2]);
  light.lamp_radius =
      kMetre * table.number_or("lamp_radius_mm", light.lamp_radius / kMetre, NumberRange{1.0, 5000.0});
  light.key = table.number_or("key", light.key, NumberRange{0.0, 10.0});
  light.ambient = table.number_or("ambient", light.ambient, NumberRange{0.01, 10.0});
  return light;
}

Quaternion turn_of(const TomlTable& table) {
  const auto q = table.numbers<4>("rotation_qwxyz", {-1.0, 1.0});
  const Quaternion rotation{q[0], q[1], q[2], q[3]};
  const double length = rotation.norm();
  if (table.has("rotation_qwxyz") && std::abs(length - 1.0) > 1e-6)
    table.complain("rotation_qwxyz",
                   fmt::format("is no rotation: w, x, y, z have length {:g}, 1 is expected", length));
  return rotation;
}

std::optional<BoardPlacement> board_of(const TomlTable& table) {
  if (!table.exists()) return std::nullopt;
  BoardPlacement placed;
  placed.board = device::charuco_board_of(table);
  const auto corner = table.numbers<3>("corner_mm", kNear);
  placed.X_world_board = {turn_of(table), kMetre * Vector3(corner[0], corner[1], corner[2])};
  return placed;
}

RealObject object_of(const TomlTable& table, std::set<std::string>& names) {
  RealObject object;
  object.name = table.text("name");
  if (table.has("name") && (object.name.empty() || !names.insert(object.name).second))
    table.complain("name", fmt::format("'{}' is empty or used twice", object.name));
  object.mesh = table.text("mesh");
  if (table.has("mesh") && object.mesh.empty()) table.complain("mesh", "is empty, a mesh file is expected");
  object.metres_per_unit = table.choice("mesh_unit", kUnits) == "m" ? 1.0 : kMetre;
  const auto place = table.numbers<3>("translation_mm", kNear);
  object.position = kMetre * Vector3(place[0], place[1], place[2]);
  object.rotation = turn_of(table);
  return object;
}

}  // namespace

device::Encoding encoding_of(const TomlTable& camera) {
  if (!camera.has("encoding")) {
    camera.expect("encoding");
    return device::Encoding::root;
  }
  const std::string word = camera.choice("encoding", kEncodings);
  return word == "srgb"     ? device::Encoding::srgb
         : word == "linear" ? device::Encoding::linear
                            : device::Encoding::root;
}

std::string_view encoding_word(device::Encoding encoding) {
  return kEncodings[static_cast<std::size_t>(encoding)];
}

void read_picture_parts(const TomlTable& file, Rig& rig) {
  rig.board = board_of(file.table("board"));
  rig.light = light_of(file.table("light"));
  std::set<std::string> names;
  for (const auto& table : file.tables("object")) rig.objects.push_back(object_of(table, names));
}

std::string picture_parts_text(const Rig& rig) {
  std::string text;
  if (rig.light) {
    text += "\n[light]\n# What virtual things are lit by: a lamp, and light from all around.\n";
    text += fmt::format("lamp_mm = {}\nlamp_radius_mm = {}\nkey = {}\nambient = {}\n",
                        number_list(rig.light->lamp, kMillimetresPerMetre),
                        number_text(rig.light->lamp_radius, kMillimetresPerMetre),
                        toml_number(rig.light->key), toml_number(rig.light->ambient));
  }
  if (rig.board) {
    const auto& [board, X_world_board] = *rig.board;
    text +=
        "\n[board]\n# A printed ChArUco board that tells where the camera is; corner_mm: its first inner "
        "corner.\n" +
        device::charuco_board_text(board);
    text += fmt::format("corner_mm = {}\nrotation_qwxyz = {}\n",
                        number_list(X_world_board.translation, kMillimetresPerMetre),
                        number_list(X_world_board.rotation));
  }
  for (const auto& object : rig.objects) {
    text += fmt::format(
        "\n[[object]]\nname = {}\nmesh = {}\nmesh_unit = \"{}\"\ntranslation_mm = {}\nrotation_qwxyz = {}\n",
        toml_quoted(object.name), toml_quoted(object.mesh), object.metres_per_unit == 1.0 ? "m" : "mm",
        number_list(object.position, kMillimetresPerMetre), number_list(object.rotation));
  }
  return text;
}

}  // namespace palpate::rig
