// What common viewers of recordings show by themselves, in the messages they know by name (foxglove.proto): frames, outlines of
// real surfaces, bodies, the tip. Times: log times, ns. Private to the module.
#pragma once

#include <cstdint>
#include <string>

#include "foxglove.pb.h"
#include "palpate/math/so3.h"
#include "palpate/scene/application.h"

namespace palpate::record::session {

// A frame's place in its parent.
void add_frame(foxglove::FrameTransforms& frames, std::uint64_t time, const std::string& parent,
               const std::string& child, const Vector3& translation, const Quaternion& rotation);
void add_surface(foxglove::SceneUpdate& update, std::uint64_t time,
                 const scene::SceneSurface& surface);  // in World
// Small spheres that move with the frame of that name.
void add_tip(foxglove::SceneUpdate& update, std::uint64_t time, const std::string& frame);
void add_body(foxglove::SceneUpdate& update, std::uint64_t time, const std::string& frame);

void set_time(google::protobuf::Timestamp& to, std::uint64_t time);

}  // namespace palpate::record::session
