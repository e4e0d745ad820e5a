// An OpenIGTLink server as a person names it for a tracker: which of its tools are which markers, and what a
// person should know where it is not heard of. One thread.
#pragma once

#include <functional>
#include <map>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "drivers/openigtlink/tracker_device.h"

namespace palpate::drivers::openigtlink {

struct LiveTracker {
  Address server;
  std::map<std::string, device::MarkerId> tools;  // the server's names
};

// igtl://HOST[:PORT], and MARKER=NAME for each tool that is not called MARKERToWorld; MARKER is tip_marker,
// camera_marker or pointer, or the frame's name (TipMarker). Errors: wrong use.
Expected<LiveTracker> parse_live_tracker(std::string_view address, const std::vector<std::string>& tools);

// Connects in the background. The server measures in World.
Expected<std::unique_ptr<OpenIgtlinkTracker>> open_live_tracker(const LiveTracker& tracker);

// Why the camera's marker may not be heard of, in words: for the conditions of the graphics server, which
// judges whether it is.
std::string why_unheard(const OpenIgtlinkTracker& tracker, const LiveTracker& named);

}  // namespace palpate::drivers::openigtlink
