#include "palpate/record/session/viewer_feed.h"

#include <algorithm>

#include "foxglove.pb.h"
#include "palpate/record/session/internal/message_parts.h"
#include "palpate/record/session/internal/viewer_messages.h"

namespace palpate::record::session {

std::string encode_scene(const scene::SceneDescription& scene, std::uint64_t time) {
  foxglove::SceneUpdate update;
  for (const auto& surface : scene.surfaces) add_surface(update, time, surface);
  add_tip(update, time, "Tip");
  for (const auto& body : scene.bodies)
    if (!body.name.empty()) add_body(update, time, body.name);
  return update.SerializeAsString();
}

std::string encode_bodies(const scene::SceneDescription& scene, const scene::SceneState& state,
                          std::uint64_t time) {
  foxglove::FrameTransforms frames;
  const auto bodies = std::min(static_cast<std::size_t>(state.body_count), scene.bodies.size());
  for (std::size_t i = 0; i < bodies; ++i)
    if (!scene.bodies[i].name.empty() && state.bodies[i].visible != 0)
      add_frame(frames, time, "World", scene.bodies[i].name, state.bodies[i].p(), state.bodies[i].q());
  return frames.transforms_size() > 0 ? frames.SerializeAsString() : std::string();
}

std::string encode_felt_force(const scene::SceneState& state) {
  recording::Plot plot;
  const Vector3 force = state.felt_force();
  plot.set_requested_n(force.norm());
  put(plot.mutable_force_n(), force);
  return plot.SerializeAsString();
}

std::string encode_log(LogLevel level, const std::string& text, std::uint64_t time) {
  foxglove::Log out;
  set_time(*out.mutable_timestamp(), time);
  switch (level) {
    case LogLevel::debug:
      out.set_level(foxglove::Log::DEBUG);
      break;
    case LogLevel::info:
      out.set_level(foxglove::Log::INFO);
      break;
    case LogLevel::warning:
      out.set_level(foxglove::Log::WARNING);
      break;
    case LogLevel::error:
      out.set_level(foxglove::Log::ERROR);
      break;
  }
  const auto colon = text.find(": ");
  out.set_name(colon == std::string::npos ? "" : text.substr(0, colon));
  out.set_message(text);
  return out.SerializeAsString();
}

}  // namespace palpate::record::session
