// A server of poses as a person names it for a tracker: which of its tools are which markers, and what a
// person should know where it is not heard of. One thread.
#pragma once

#include <functional>
#include <map>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "drivers/network/marker_tracker.h"
#include "palpate/device/driver_registry.h"

namespace palpate::drivers::network {

struct LiveTracker {
  Address server;
  std::map<std::string, device::MarkerId> tools;  // the server's names
};

// SCHEME://HOST[:PORT], and MARKER=NAME for each tool that is not called MARKERToWorld; MARKER is tip_marker,
// camera_marker or pointer, or the frame's name (TipMarker). A name is cut to `longest_name`. Errors: wrong use.
Expected<LiveTracker> parse_live_tracker(std::string_view uri, const std::vector<std::string>& tools,
                                         const Protocol& protocol, std::size_t longest_name);

// Why the camera's marker may not be heard of, in words: for the conditions of the graphics server, which
// judges whether it is.
std::string why_unheard(const MarkerTracker& tracker, const LiveTracker& named, const Protocol& protocol);

// A driver for such servers: `connect` begins to listen to one. The server measures in World.
using Connect = std::function<Expected<std::unique_ptr<PoseClient>>(const Address&)>;
device::Driver tracker_driver(const Protocol& protocol, std::size_t longest_name, std::string scheme,
                              std::string summary, Connect connect);

}  // namespace palpate::drivers::network
