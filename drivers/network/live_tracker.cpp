#include "drivers/network/live_tracker.h"

#include <fmt/ranges.h>

#include <algorithm>

#include "palpate/core/text.h"
#include "palpate/device/live_name.h"

namespace palpate::drivers::network {
namespace {

// As the options say them, and as frames are called.
constexpr std::pair<std::string_view, device::MarkerId> kMarkers[] = {
    {"tip_marker", device::MarkerId::tip_marker},
    {"TipMarker", device::MarkerId::tip_marker},
    {"camera_marker", device::MarkerId::camera_marker},
    {"CameraMarker", device::MarkerId::camera_marker},
    {"pointer", device::MarkerId::pointer},
    {"Pointer", device::MarkerId::pointer}};

}  // namespace

Expected<LiveTracker> parse_live_tracker(std::string_view uri, const std::vector<std::string>& tools,
                                         const Protocol& protocol, std::size_t longest_name) {
  if (!uri.starts_with(protocol.scheme))
    return wrong_use("'{}': {}HOST:PORT of {} is expected", excerpt(uri, 100), protocol.scheme,
                     protocol.server);
  auto server = parse_server(uri.substr(std::string_view(protocol.scheme).size()), protocol);
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
    names[marker->second] = tool.substr(equals + 1).substr(0, longest_name);
  }
  for (const auto& [marker, name] : names)
    if (!tracker.tools.emplace(name, marker).second)
      return wrong_use("'{}': named for two markers; a tool of its own is expected for each",
                       excerpt(name, 100));
  return tracker;
}

std::string why_unheard(const MarkerTracker& tracker, const LiveTracker& named, const Protocol& protocol) {
  const std::string where = named.server.text();
  if (!tracker.state().connected)
    return fmt::format(
        "tracker: no {} server answers at {}; start it or check the address, drawing goes on with "
        "the camera's last pose",
        protocol.name, where);
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

namespace {

class OpenedLiveTracker : public device::OpenedTracker {
 public:
  OpenedLiveTracker(LiveTracker named, const Protocol& protocol, std::unique_ptr<MarkerTracker> tracker)
      : named_(std::move(named)), protocol_(protocol), tracker_(std::move(tracker)) {}
  device::TrackerDevice& device() override { return *tracker_; }
  std::string why_unheard() const override { return network::why_unheard(*tracker_, named_, protocol_); }

 private:
  LiveTracker named_;
  Protocol protocol_;
  std::unique_ptr<MarkerTracker> tracker_;
};

}  // namespace

device::Driver tracker_driver(const Protocol& protocol, std::size_t longest_name, std::string scheme,
                              std::string summary, Connect connect) {
  device::Driver driver;
  driver.scheme = std::move(scheme);
  driver.summary = std::move(summary);
  driver.tracker.emplace();
  driver.tracker->form = fmt::format("{}HOST:PORT of {}", protocol.scheme, protocol.server);
  driver.tracker->names = [protocol](std::string_view uri) { return uri.starts_with(protocol.scheme); };
  driver.tracker->check = [protocol, longest_name](const device::TrackerRequest& request) -> Expected<void> {
    if (const auto named = parse_live_tracker(request.uri, request.tools, protocol, longest_name); !named)
      return tl::unexpected(named.error());
    return {};
  };
  driver.tracker->open =
      [protocol, longest_name,
       connect](const device::TrackerRequest& request) -> Expected<std::unique_ptr<device::OpenedTracker>> {
    auto named = parse_live_tracker(request.uri, request.tools, protocol, longest_name);
    if (!named) return tl::unexpected(named.error());
    auto client = connect(named->server);
    if (!client) return tl::unexpected(client.error());
    TrackerMapping mapping;
    mapping.markers = named->tools;
    auto tracker = std::make_unique<MarkerTracker>(std::move(*client), std::move(mapping));
    return std::make_unique<OpenedLiveTracker>(std::move(*named), protocol, std::move(tracker));
  };
  return driver;
}

}  // namespace palpate::drivers::network
