#include "tools/commands/lens_file.h"

#include <algorithm>

#include "palpate/core/file.h"
#include "palpate/core/json.h"

namespace palpate::tools::commands {
namespace {

Expected<device::CameraModel> lens_from_json(const std::string& file, const std::string& content) {
  const auto json = Json::parse(content, nullptr, false);
  const auto number = [&](const char* key) { return json.contains(key) && json[key].is_number(); };
  for (const char* key : {"fx", "fy", "cx", "cy", "width_px", "height_px"})
    if (json.is_discarded() || !json.is_object() || !number(key))
      return wrong_use("{}: no number '{}'; a rig file, or what calibrate camera --json writes, is expected",
                       file, key);
  device::CameraModel lens;
  lens.width = json["width_px"].get<int>(), lens.height = json["height_px"].get<int>();
  lens.fx = json["fx"].get<double>(), lens.fy = json["fy"].get<double>();
  lens.cx = json["cx"].get<double>(), lens.cy = json["cy"].get<double>();
  const auto list = json.value("distortion", Json::array());
  if (!list.is_array() || list.size() != lens.distortion.size() ||
      !std::all_of(list.begin(), list.end(), [](const Json& k) { return k.is_number(); }) ||
      !(lens.fx > 0.0) || !(lens.fy > 0.0))
    return wrong_use("{}: 'distortion' k1 k2 p1 p2 k3 and focal lengths above 0 are expected", file);
  for (std::size_t i = 0; i < lens.distortion.size(); ++i) lens.distortion[i] = list[i].get<double>();
  return lens;
}

std::optional<device::CameraModel> lens_of(const rig::Rig& rig, const std::string& camera) {
  const auto& calibration = camera == "right" ? rig.right_camera : rig.camera;
  if (!calibration) return std::nullopt;
  return calibration->model;
}

}  // namespace

Expected<std::optional<device::CameraModel>> given_lens(const std::string& file, const rig::Rig& rig,
                                                        const std::string& camera) {
  if (file.empty()) return lens_of(rig, camera);
  const auto content = read_file(file);
  if (!content) return tl::unexpected(content.error());
  if (const auto first = content->find_first_not_of(" \t\r\n");
      first != std::string::npos && (*content)[first] == '{') {
    const auto lens = lens_from_json(file, *content);
    if (!lens) return tl::unexpected(lens.error());
    return std::optional(*lens);
  }
  const auto other = rig::read_rig(file);
  if (!other) return tl::unexpected(other.error());
  const auto lens = lens_of(*other, camera);
  if (!lens) return wrong_use("{}: has no lens of the {} camera; calibrate camera writes one", file, camera);
  return lens;
}

}  // namespace palpate::tools::commands
