#include "drivers/openigtlink/live_tracker.h"

#include <fmt/ranges.h>

#include <algorithm>

#include "palpate/core/text.h"
#include "palpate/device/live_name.h"

namespace palpate::drivers::openigtlink {
namespace {

constexpr std::string_view kScheme = "igtl://";
// As the options say them, and as frames are called.
constexpr std::pair<std::string_view, device::MarkerId> kMarkers[] = {
    {"tip_marker", device::MarkerId::tip_marker},
    {"TipMarker", device::MarkerId::tip_marker},
    {"camera_marker", device::MarkerId::camera_marker},
    {"CameraMarker", device::MarkerId::camera_marker},
    {"pointer", device::MarkerId::pointer},
    {"Pointer", device::MarkerId::pointer}};

}  // namespace

Expected<LiveTracker> parse_live_tracker(std::string_view address, const std::vector<std::string>& tools) {
  if (!address.starts_with(kScheme))
    return wrong_use("'{}': igtl://HOST:PORT of an OpenIGTLink server is expected", excerpt(address, 100));
  auto server = parse_server(address.substr(kScheme.size()));
  if (!server) return tl::unexpected(server.error());
  LiveTracker tracker{*server, {}};
  std::map<device::MarkerId, std::string> names;
  for (const auto& [word, marker] : kMarkers) names[marker] = device::live_name(marker);
  for (const auto& tool : tools) {
    const auto equals = tool.find('=');
    const auto* marker = std::find_if(std::begin(kMarkers), std::end(kMarkers), [&](const auto& known) {
      return equals != std::string::npos && known.first == std::string_view(tool).substr(0, equals);
    });
    if (marker == std::end(kMarkers) || equals + 1 == tool.size())
      return wrong_use(
          "'{}': MARKER=NAME is expected, MARKER one of tip_marker, camera_marker, pointer and NAME the "
          "server's tool",
          excerpt(tool, 100));
    names[marker->second] = tool.substr(equals + 1).substr(0, kNameBytes);
  }
  for (const auto& [marker, name] : names)
    if (!tracker.tools.emplace(name, marker).second)
      return wrong_use("'{}': named for two markers; a tool of its own is expected for each",
                       excerpt(name, 100));
  return tracker;
}

Expected<std::unique_ptr<OpenIgtlinkTracker>> open_live_tracker(const LiveTracker& tracker) {
  auto client = TrackerClient::connect(tracker.server);
  if (!client) return tl::unexpected(client.error());
  TrackerMapping mapping;
  mapping.markers = tracker.tools;
  return std::make_unique<OpenIgtlinkTracker>(std::move(*client), std::move(mapping));
}

std::string why_unheard(const OpenIgtlinkTracker& tracker, const LiveTracker& named) {
  const std::string where = named.server.text();
  if (!tracker.state().connected)
    return fmt::format(
        "tracker: no OpenIGTLink server answers at {}; start it or check the address, drawing goes on with "
        "the camera's last pose",
        where);
  const auto name = std::find_if(named.tools.begin(), named.tools.end(), [](const auto& tool) {
                      return tool.second == device::MarkerId::camera_marker;
                    })->first;
  if (tracker.seen(device::MarkerId::camera_marker) == 0 && !tracker.others().empty())
    return fmt::format(
        "tracker: the server at {} sends no '{}'; there are {}: name the camera's marker with "
        "--tracker-tool camera_marker=NAME",
        where, excerpt(name), excerpt(fmt::format("{}", fmt::join(tracker.others(), ", ")), 160));
  return fmt::format(
      "tracker: the server at {} does not see '{}' (the head's marker); turn it towards the tracker, or take "
      "away what stands between",
      where, excerpt(name));
}

}  // namespace palpate::drivers::openigtlink
