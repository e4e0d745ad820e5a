// An OpenIGTLink server as the graphics server's tracker: which of its tools are which markers, and what a
// person should know when it falls silent. One thread.
#pragma once

#include <functional>
#include <map>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "palpate/drivers/openigtlink/tracker_device.h"

namespace palpate {

struct LiveTracker {
  igtl::Address server;
  std::map<std::string, MarkerId> tools;  // the server's names
};

// igtl://HOST[:PORT], and MARKER=NAME for each tool that is not called MARKERToWorld; MARKER is TipMarker,
// CameraMarker or Pointer. Errors: wrong use.
Expected<LiveTracker> parse_live_tracker(std::string_view address, const std::vector<std::string>& tools);

// Connects in the background. The server measures in World.
Expected<std::unique_ptr<igtl::OpenIgtlinkTracker>> open_live_tracker(const LiveTracker& tracker);

// Tells that the camera's marker is not heard of, with the likely reason, once per reason, and once that it
// is again.
class TrackerWatch {
 public:
  static constexpr Duration kSilent = std::chrono::seconds(2);

  TrackerWatch(const igtl::OpenIgtlinkTracker& tracker, LiveTracker named, Instant<GraphicsClock> now)
      : tracker_(tracker), named_(std::move(named)), heard_(now) {}
  // A line for a person, where there is news.
  std::optional<std::string> look(Instant<GraphicsClock> now);

 private:
  std::string reason() const;

  const igtl::OpenIgtlinkTracker& tracker_;
  const LiveTracker named_;
  Instant<GraphicsClock> heard_;
  std::uint64_t seen_ = 0;
  bool silent_ = false, connected_ = false;
};

}  // namespace palpate
