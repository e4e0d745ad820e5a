// A pose that a server of poses sends, whatever its protocol. Values.
#pragma once

#include <cstdint>
#include <string>

#include "palpate/math/so3.h"
#include "palpate/time/instant.h"

namespace palpate::drivers::network {

struct RigidPose {
  Quaternion rotation = Quaternion::Identity();
  Vector3 translation = Vector3::Zero();  // m
};

struct ToolSample {
  std::string tool;
  // The server's time of the measurement; where it states none (server_time false), the time of arrival on
  // this machine's monotonic clock.
  Instant<TrackerClock> stamp;
  bool server_time = false;
  std::int64_t arrived_ns = 0;  // on this machine's monotonic clock
  bool seen = true;             // false: the server says that the pose is not valid
  RigidPose pose;
};

}  // namespace palpate::drivers::network
