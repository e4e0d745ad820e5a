#include "tools/console/page_messages.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>

#include "palpate/core/json.h"
#include "palpate/core/little_endian.h"
#include "palpate/core/text.h"
#include "palpate/transport/status_json.h"

namespace palpate::tools::console {
namespace {

std::string text_of(const Json& json) { return json.dump(-1, ' ', false, Json::error_handler_t::replace); }

// A thousandth of a millimetre, of a newton: a page shows less.
double rounded(double value) { return std::round(value * 1e6) / 1e6; }
Json vector(const Vector3& v) { return Json::array({rounded(v.x()), rounded(v.y()), rounded(v.z())}); }

Json body(const scene::BodyState& state) {
  const auto& q = state.orientation;
  const Vector3 p = state.p();
  return Json::array({rounded(p.x()), rounded(p.y()), rounded(p.z()), rounded(q[0]), rounded(q[1]),
                      rounded(q[2]), rounded(q[3]), state.visible != 0});
}

}  // namespace

std::string scene_message(const scene::SceneDescription& scene) {
  Json json{{"op", "scene"},
            {"application", scene.application},
            {"surfaces", Json::array()},
            {"bodies", Json::array()}};
  for (const auto& surface : scene.surfaces) {
    Json corners = Json::array();
    for (const Vector3& corner : surface.corners) corners.push_back(vector(corner));
    json["surfaces"].push_back({{"name", surface.name}, {"corners", std::move(corners)}});
  }
  for (const auto& one : scene.bodies) json["bodies"].push_back(one.name);
  return text_of(json);
}

std::string states_message(const std::vector<scene::SceneState>& states) {
  Json json{{"op", "states"},          {"t_ns", fmt::format("{}", states.back().time.ns())},
            {"dt_ms", Json::array()},  {"force", Json::array()},
            {"bodies", Json::array()}, {"touch", Json()}};
  const auto& newest = states.back();
  for (const auto& state : states) {
    json["dt_ms"].push_back(rounded(1e3 * to_seconds(state.time - newest.time)));
    json["force"].push_back(vector(state.felt_force()));
  }
  const int count = std::clamp(newest.body_count, 0, scene::SceneState::kBodies);
  for (int i = 0; i < count; ++i) json["bodies"].push_back(body(newest.bodies[static_cast<std::size_t>(i)]));
  if (newest.impact.share > 0.0)
    json["touch"] = vector(Vector3(newest.impact.point.data()));
  else if (newest.continuous.touching != 0)
    json["touch"] = vector(Vector3(newest.continuous.point.data()));
  return text_of(json);
}

std::string status_message(const SystemView& view, const std::vector<Event>& news,
                           const PageFigures& figures) {
  Json json{{"op", "status"}, {"lights", Json::array()}, {"events", Json::array()}};
  for (const auto& light : lights_of(view))
    json["lights"].push_back({{"name", light.name}, {"level", name_of(light.level)}, {"words", light.words}});
  for (const auto& event : news)
    json["events"].push_back({{"number", event.number},
                              {"time_s", event.time_s},
                              {"level", name_of(event.level)},
                              {"words", event.words}});
  json["status"] = view.status ? transport::status_json(*view.status) : Json();
  json["console"] = {{"viewers", figures.viewers},
                     {"states_missed", figures.states_missed},
                     {"page_dropped", figures.page_dropped},
                     {"shown_after_ms", figures.shown_after_ms},
                     {"controls", figures.controls}};
  return text_of(json);
}

std::string picture_message(const transport::ShownPicture& picture, std::string_view jpeg) {
  const std::string head = text_of(
      {{"number", picture.number},
       {"width", picture.width},
       {"height", picture.height},
       {"pose", picture.pose},
       {"landmarks_used", picture.landmarks_used},
       {"landmarks_predicted", picture.landmarks_predicted},
       {"landmark_rms_px", picture.landmark_rms_px},
       {"expected_overlay_px", picture.expected_overlay_px ? Json(*picture.expected_overlay_px) : Json()},
       {"landmarks", transport::landmarks_json(picture)}});
  std::string bytes;
  append_little_endian(bytes, static_cast<std::uint32_t>(head.size()));
  bytes += head;
  bytes += jpeg;
  return bytes;
}

std::string refusal_message(const std::string& words) {
  return text_of({{"op", "refusal"}, {"words", words}});
}

PageSaying read_page_message(std::string_view text) {
  const Json json = Json::parse(text, nullptr, false);
  const auto word = [&](const char* key) {
    const auto found = json.find(key);
    return found != json.end() && found->is_string() ? found->get<std::string>() : std::string();
  };
  if (!json.is_object()) return {};
  const std::string op = word("op"), time = word("t_ns");
  if (op == "control") return {PageSaying::Kind::control, 0, word("control"), word("token")};
  std::int64_t ns = 0;
  const char* end = time.data() + time.size();
  const auto [stopped, failure] = std::from_chars(time.data(), end, ns);
  if (op != "seen" || failure != std::errc() || stopped != end || ns < 0) return {};
  return {PageSaying::Kind::seen, ns, {}, {}};
}

}  // namespace palpate::tools::console
