#include "drivers/ndi/driver.h"

#include "drivers/ndi/protocol.h"
#include "drivers/network/live_tracker.h"

namespace palpate::drivers::ndi {
namespace {

// The address without the files, which the tracker of any protocol knows nothing of.
device::TrackerRequest plain(const device::TrackerRequest& request,
                             std::vector<std::string>* files = nullptr) {
  device::TrackerRequest without = request;
  const std::string_view uri = request.uri, scheme = kProtocol.scheme;
  if (!uri.starts_with(scheme)) return without;
  auto place = split_place(uri.substr(scheme.size()));
  without.uri = std::string(scheme) + place.server;
  if (files != nullptr) *files = std::move(place.files);
  return without;
}

device::Driver any_tracker(const ClientOptions& options) {
  return network::tracker_driver(
      kProtocol, kMostNameBytes, "ndi", "NDI trackers (Polaris, Vega, Aurora) by their combined API",
      [options](const network::Address& server) { return connect(server, options); });
}

}  // namespace

void add_to(device::DriverRegistry& registry) {
  auto driver = any_tracker({});
  driver.tracker->form += ", /FILE.rom,... behind it for wireless tools";
  driver.tracker->check =
      [check = driver.tracker->check](const device::TrackerRequest& request) -> Expected<void> {
    std::vector<std::string> files;
    if (auto fine = check(plain(request, &files)); !fine) return fine;
    if (const auto definitions = read_definitions(files); !definitions)
      return tl::unexpected(definitions.error());
    return {};
  };
  driver.tracker->open =
      [](const device::TrackerRequest& request) -> Expected<std::unique_ptr<device::OpenedTracker>> {
    std::vector<std::string> files;
    const auto without = plain(request, &files);
    auto definitions = read_definitions(files);
    if (!definitions) return tl::unexpected(definitions.error());
    return any_tracker({.wireless = std::move(*definitions)}).tracker->open(without);
  };
  registry.add(std::move(driver));
}

}  // namespace palpate::drivers::ndi
