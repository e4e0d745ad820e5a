#include "drivers/network/marker_tracker.h"

#include <algorithm>

#include "palpate/time/clock.h"

namespace palpate::drivers::network {

std::vector<device::TrackerSample> MarkerTracker::poll() {
  std::vector<device::TrackerSample> samples;
  for (const auto& heard : client_->poll()) {
    const auto marker = mapping_.markers.find(heard.tool);
    if (marker == mapping_.markers.end()) {
      others_.insert(heard.tool);
      continue;
    }
    seen_[static_cast<std::size_t>(marker->second)] += heard.seen ? 1 : 0;
    device::TrackerSample& sample = samples.emplace_back();
    sample.stamp = heard.stamp;
    sample.marker = marker->second;
    sample.seen = heard.seen;
    const std::int64_t since = MonotonicClock<TrackerClock>::monotonic_ns() - heard.arrived_ns;
    sample.waited = Duration(std::max<std::int64_t>(0, since));
    const auto X_world_tool =
        mapping_.X_world_server * Pose<ServerFrame, TipMarker>{heard.pose.rotation, heard.pose.translation};
    sample.rotation = X_world_tool.rotation;
    sample.translation = X_world_tool.translation;
    sample.covariance.diagonal().head<3>().setConstant(mapping_.rotation_sd * mapping_.rotation_sd);
    sample.covariance.diagonal().tail<3>().setConstant(mapping_.translation_sd * mapping_.translation_sd);
    sample.systematic.diagonal().setConstant(mapping_.systematic_sd * mapping_.systematic_sd);
  }
  return samples;
}

}  // namespace palpate::drivers::network
