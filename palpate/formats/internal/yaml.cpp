// YAML: OpenCV's FileStorage, ROS' camera_info, Kalibr's chain of cameras, easy_handeye. The only place that knows yaml-cpp.
//
// easy_handeye2 writes `transform:` with `rotation` and `translation`, and `calibration_type: eye_in_hand` or eye_on_base.
// OpenCV's first line, "%YAML:1.0", is no directive of YAML 1.2, and is left out. easy_handeye: the camera's base in the
// effector where `eye_on_hand` is true, else in the robot's base; m.
#include <yaml-cpp/yaml.h>

#include <cmath>
#include <limits>

#include "palpate/core/text.h"
#include "palpate/core/units.h"
#include "palpate/formats/internal/forms.h"
#include "palpate/formats/internal/lens_keys.h"
#include "palpate/formats/internal/text_table.h"
#include "palpate/math/so3.h"

namespace palpate::formats {
namespace {

constexpr std::size_t kMostNumbers = 10'000;

std::optional<double> number_at(const YAML::Node& node) {
  if (!node.IsDefined() || !node.IsScalar()) return std::nullopt;
  return number_of(node.Scalar());
}

void take_numbers(const YAML::Node& node, std::vector<double>& numbers, bool& sound, int depth = 0) {
  if (depth > 3 || numbers.size() > kMostNumbers) {
    sound = false;
  } else if (node.IsSequence()) {
    for (const auto& part : node) take_numbers(part, numbers, sound, depth + 1);
  } else if (const auto number = number_at(node)) {
    numbers.push_back(*number);
  } else {
    sound = false;
  }
}

// Of a list, of lists in a list, of {rows, cols, data}, or of one number.
std::optional<std::vector<double>> numbers_in(const YAML::Node& node) {
  if (!node.IsDefined()) return std::nullopt;
  std::vector<double> numbers;
  bool sound = true;
  if (node.IsMap()) {
    const auto data = node["data"];
    if (data.IsDefined()) take_numbers(data, numbers, sound);
  } else {
    take_numbers(node, numbers, sound);
  }
  if (!sound || numbers.empty()) return std::vector{std::numeric_limits<double>::quiet_NaN()};
  return numbers;
}

// qw qx qy qz x y z under `keys`, the first four in `turn`.
Expected<std::array<double, 7>> seven_numbers(const YAML::Node& turn, const YAML::Node& shift,
                                              const std::string& within,
                                              const std::array<const char*, 7>& keys,
                                              const std::string& source) {
  std::array<double, 7> v{};
  for (std::size_t i = 0; i < v.size(); ++i) {
    const auto& node = i < 4 ? turn : shift;
    const auto number = node.IsDefined() && node.IsMap() ? number_at(node[keys[i]]) : std::nullopt;
    if (!number)
      return wrong_use(
          "{}: {}.{} is no number; a quaternion w x y z and a place x y z are expected, as easy_handeye has "
          "them",
          source, within, keys[i]);
    v[i] = *number;
  }
  return v;
}

Expected<Content> hand_eye(const Expected<std::array<double, 7>>& read, bool on_hand,
                           const std::string& source) {
  if (!read) return tl::unexpected(read.error());
  const auto& v = *read;
  const Quaternion q(v[0], v[1], v[2], v[3]);
  if (!(std::abs(q.norm() - 1.0) < 0.02))
    return wrong_use("{}: the quaternion has length {:.4g}, a rotation (length 1) is expected", source,
                     q.norm());
  Transform transform;
  transform.matrix.topLeftCorner<3, 3>() = q.normalized().toRotationMatrix();
  transform.matrix.topRightCorner<3, 1>() = Vector3(v[4], v[5], v[6]);
  if (!(Vector3(v[4], v[5], v[6]).cwiseAbs().maxCoeff() <= kFarthestPlace))
    return wrong_use("{}: the translation is too large; metres are expected", source);
  return Content{"a result of easy_handeye",
                 on_hand ? "the camera in the effector, m" : "the camera in the robot's base, m", transform};
}

// cam0, cam1, ... of Kalibr; the one that is named, or the only one.
Expected<Content> camera_of_chain(const YAML::Node& root, const std::string& wanted,
                                  const std::string& source) {
  std::string names, name = wanted;
  std::size_t count = 0;
  for (const auto& entry : root)
    if (entry.first.IsScalar() && entry.first.Scalar().starts_with("cam") && entry.second.IsMap()) {
      names += (names.empty() ? "" : ", ") + excerpt(entry.first.Scalar(), 20);
      if (++count == 1 && wanted.empty()) name = entry.first.Scalar();
    }
  if (wanted.empty() && count > 1)
    return wrong_use("{}: is a chain of {} cameras of Kalibr ({}); name one with --tool", source, count,
                     names);
  const auto camera = root[name];
  if (!camera.IsDefined() || !camera.IsMap())
    return wrong_use("{}: has no camera '{}'; it has {}", source, excerpt(name), names);
  const auto word = [&](const char* key) {
    return camera[key].IsDefined() && camera[key].IsScalar() ? camera[key].Scalar() : std::string();
  };
  if (word("camera_model") != "pinhole")
    return wrong_use("{}: {} is a camera '{}' of Kalibr; a pinhole with radtan or equidistant is expected",
                     source, excerpt(name), excerpt(word("camera_model")));
  const auto model = word("distortion_model");
  if (model != "radtan" && model != "equidistant" && model != "none")
    return wrong_use(
        "{}: {} has the lens '{}' of Kalibr; radtan (k1 k2 p1 p2) or equidistant (k1 k2 k3 k4) is expected",
        source, excerpt(name), excerpt(model));
  const auto lens = lens_of([&](const std::string& key) { return numbers_in(camera[key]); },
                            model == "equidistant" ? model : "", source);
  if (!lens) return tl::unexpected(lens.error());
  return Content{"a camera of Kalibr, " + excerpt(name, 20),
                 lens->kind == device::LensKind::fisheye ? "px, k1 k2 k3 k4" : "px, k1 k2 p1 p2", *lens};
}

Expected<Content> content_of(const YAML::Node& root, const Source& from) {
  const std::string& source = from.name;
  const std::string_view content = from.content;
  if (root.IsMap() && root["cam0"].IsDefined() && root["cam0"].IsMap())
    return camera_of_chain(root, from.options.tool, source);
  if (root.IsMap() && root["transformation"].IsDefined() && root["transformation"].IsMap()) {
    const auto parameters = root["parameters"];
    const auto where =
        parameters.IsDefined() && parameters.IsMap() ? parameters["eye_on_hand"] : root["eye_on_hand"];
    const auto node = root["transformation"];
    return hand_eye(
        seven_numbers(node, node, "transformation", {"qw", "qx", "qy", "qz", "x", "y", "z"}, source),
        where.IsDefined() && where.IsScalar() && where.Scalar() == "true", source);
  }
  if (root.IsMap() && root["transform"].IsDefined() && root["transform"].IsMap()) {  // easy_handeye2
    const auto node = root["transform"], parameters = root["parameters"];
    const auto type =
        parameters.IsDefined() && parameters.IsMap() ? parameters["calibration_type"] : YAML::Node();
    return hand_eye(seven_numbers(node["rotation"], node["translation"], "transform",
                                  {"w", "x", "y", "z", "x", "y", "z"}, source),
                    type.IsDefined() && type.IsScalar() && type.Scalar() == "eye_in_hand", source);
  }
  const NumbersAt numbers_at = [&root](const std::string& key) -> std::optional<std::vector<double>> {
    if (!root.IsMap()) return std::nullopt;
    return numbers_in(root[key]);
  };
  if (!has_lens(numbers_at) && !numbers_at("M2"))
    return wrong_use(
        "{}: is YAML of a kind that is not known here; a lens (camera_matrix), or a transformation of "
        "easy_handeye, is expected",
        source);
  const bool ros = root["distortion_model"].IsDefined() || root["camera_name"].IsDefined();
  std::string model = root["distortion_model"].IsDefined() && root["distortion_model"].IsScalar()
                          ? root["distortion_model"].Scalar()
                          : std::string();
  // As OpenCV's calibration program says it.
  if (const auto flag = number_at(root["fisheye_model"]); flag && *flag != 0.0) model = "fisheye";
  // "omni" and others beside the lens's own bend.
  if (const auto camera = root["camera_model"];
      camera.IsDefined() && camera.IsScalar() && camera.Scalar() != "pinhole")
    model = camera.Scalar();
  const auto chosen = one_camera(numbers_at, from.options.tool, source);
  if (!chosen) return tl::unexpected(chosen.error());
  const auto lens = lens_of(*chosen, model, source);
  if (!lens) return tl::unexpected(lens.error());
  return Content{ros                                ? "a camera_info of ROS"
                 : content.starts_with("%YAML:1.0") ? "a lens of OpenCV (YAML)"
                                                    : "a lens in YAML",
                 told_of(*lens), *lens};
}

}  // namespace

bool is_yaml(std::string_view content) {
  if (content.starts_with("%YAML")) return true;
  while (const auto raw = next_line(content)) {
    const auto line = trimmed(*raw);
    if (line.empty() || line.front() == '#' || line == "---") continue;
    const auto colon = line.find(':');
    if (colon == std::string_view::npos || colon == 0) return false;
    if (colon + 1 < line.size() && line[colon + 1] != ' ') return false;
    return line.find_first_of("{[,;\t=") >= colon;
  }
  return false;
}

Expected<Content> read_yaml(const Source& source) {
  std::string_view content = source.content;
  if (content.size() > kMostBytesOfAFew)
    return wrong_use("{}: is YAML of more than {} bytes; a lens or a transform is expected", source.name,
                     kMostBytesOfAFew);
  if (content.starts_with("%YAML")) next_line(content);
  try {
    return content_of(YAML::Load(std::string(content)), source);
  } catch (const YAML::Exception& error) {
    return wrong_use("{}:{}: is no sound YAML ({})", source.name, error.mark.line + 1,
                     excerpt(error.msg, 120));
  }
}

}  // namespace palpate::formats
