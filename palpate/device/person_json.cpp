#include "palpate/device/person_json.h"

#include <array>
#include <utility>

#include "palpate/core/text.h"

namespace palpate::device {
namespace {

constexpr std::array<std::pair<Gesture, std::string_view>, 9> kNames{
    {{Gesture::rest, "rest"},
     {Gesture::next_pose, "next_pose"},
     {Gesture::swing_stylus, "swing_stylus"},
     {Gesture::wander, "wander"},
     {Gesture::swing_pointer, "swing_pointer"},
     {Gesture::touch, "touch"},
     {Gesture::look_around_board, "look_around_board"},
     {Gesture::look, "look"},
     {Gesture::hold, "hold"}}};
constexpr int kMostPlaces = 1000;  // landmarks of a rig

template <std::size_t N>
std::optional<std::array<double, N>> numbers(const Json& json, const char* key) {
  const auto found = json.find(key);
  if (found == json.end() || !found->is_array() || found->size() != N) return std::nullopt;
  std::array<double, N> values{};
  for (std::size_t i = 0; i < N; ++i) {
    if (!(*found)[i].is_number()) return std::nullopt;
    values[i] = (*found)[i].template get<double>();
  }
  return values;
}

}  // namespace

std::string_view name_of(Gesture gesture) {
  for (const auto& [known, name] : kNames)
    if (known == gesture) return name;
  return "";
}

Json json_of(const Request& request) {
  Json json{{"gesture", name_of(request.gesture)}};
  if (request.gesture == Gesture::touch) {
    json["what"] = request.what;
    json["index"] = request.index;
  }
  if (request.gesture == Gesture::hold) json["index"] = request.index;
  if (request.gesture == Gesture::swing_stylus && !request.what.empty()) json["what"] = request.what;
  if (request.target) {
    const Quaternion& q = request.target->R_world_marker;
    const Vector3& tip = request.target->tip.m;
    json["tip_m"] = {tip.x(), tip.y(), tip.z()};
    json["marker_rotation_qwxyz"] = {q.w(), q.x(), q.y(), q.z()};
  }
  return json;
}

Expected<Request> request_of(const Json& json) {
  Request request;
  const auto gesture = json.is_object() ? json.find("gesture") : json.end();
  if (!json.is_object() || gesture == json.end() || !gesture->is_string())
    return wrong_use("an object with a \"gesture\" is expected");
  bool known = false;
  for (const auto& [value, name] : kNames)
    if (gesture->get_ref<const std::string&>() == name) {
      request.gesture = value;
      known = true;
    }
  if (!known) return wrong_use("gesture: is '{}'", excerpt(gesture->get_ref<const std::string&>(), 40));
  if (request.gesture == Gesture::touch) {
    const auto what = json.find("what"), index = json.find("index");
    if (what == json.end() || !what->is_string() || index == json.end() || !index->is_number_integer() ||
        index->get<std::int64_t>() < 0 || index->get<std::int64_t>() > kMostPlaces)
      return wrong_use("touch: \"what\", a name, and \"index\", 0 to {}, are expected", kMostPlaces);
    request.what = what->get<std::string>();
    request.index = index->get<int>();
  }
  if (request.gesture == Gesture::hold && json.contains("index")) {
    const auto& index = json["index"];
    if (!index.is_number_integer() || index.get<std::int64_t>() < 0 ||
        index.get<std::int64_t>() > kMostPlaces)
      return wrong_use("hold: \"index\", 0 to {}, is expected", kMostPlaces);
    request.index = index.get<int>();
  }
  if (request.gesture == Gesture::swing_stylus && json.contains("what")) {
    if (json["what"] != "hollow") return wrong_use("swing_stylus: \"what\" is \"hollow\" or left out");
    request.what = "hollow";
  }
  if (json.contains("tip_m")) {
    const auto tip = numbers<3>(json, "tip_m");
    const auto turn = numbers<4>(json, "marker_rotation_qwxyz");
    if (!tip || !turn)
      return wrong_use("tip_m: three numbers, and four of marker_rotation_qwxyz, are expected");
    const Quaternion q((*turn)[0], (*turn)[1], (*turn)[2], (*turn)[3]);
    if (!(q.norm() > 0.5)) return wrong_use("marker_rotation_qwxyz: is no rotation");
    request.target = PoseTarget{{Vector3((*tip)[0], (*tip)[1], (*tip)[2])}, q.normalized(), Vector3::Zero()};
  }
  return request;
}

}  // namespace palpate::device
