// What common viewers show by themselves of a scene and its states (foxglove.proto), as it is recorded and as it is served
// live. Pure; any thread. World frame; times: log times, ns since 1970.
#pragma once

#include <cstdint>
#include <string>

#include "palpate/core/log.h"
#include "palpate/scene/application.h"
#include "palpate/scene/scene_state.h"

namespace palpate::record::session {

// foxglove.SceneUpdate: outlines of the real surfaces, the tip, the named bodies. Said again and again: who begins to look in
// the middle has missed the first.
std::string encode_scene(const scene::SceneDescription& scene, std::uint64_t time);

// foxglove.FrameTransforms: the named bodies that can be seen. Empty: there are none.
std::string encode_bodies(const scene::SceneDescription& scene, const scene::SceneState& state,
                          std::uint64_t time);

// palpate.recording.Plot of what an observer knows: the force that is asked for.
std::string encode_felt_force(const scene::SceneState& state);

// foxglove.Log of a line of the log; what stands before its first ": " is the part it comes from.
std::string encode_log(LogLevel level, const std::string& text, std::uint64_t time);

}  // namespace palpate::record::session
