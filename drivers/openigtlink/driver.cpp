#include "drivers/openigtlink/driver.h"

#include "drivers/openigtlink/live_tracker.h"

namespace palpate::drivers::openigtlink {
namespace {

class OpenedLiveTracker : public device::OpenedTracker {
 public:
  OpenedLiveTracker(LiveTracker named, std::unique_ptr<OpenIgtlinkTracker> tracker)
      : named_(std::move(named)), tracker_(std::move(tracker)) {}
  device::TrackerDevice& device() override { return *tracker_; }
  std::string why_unheard() const override { return openigtlink::why_unheard(*tracker_, named_); }

 private:
  LiveTracker named_;
  std::unique_ptr<OpenIgtlinkTracker> tracker_;
};

Expected<std::unique_ptr<device::OpenedTracker>> open_tracker(const device::TrackerRequest& request) {
  auto named = parse_live_tracker(request.uri, request.tools);
  if (!named) return tl::unexpected(named.error());
  auto tracker = open_live_tracker(*named);
  if (!tracker) return tl::unexpected(tracker.error());
  return std::make_unique<OpenedLiveTracker>(std::move(*named), std::move(*tracker));
}

}  // namespace

void add_to(device::DriverRegistry& registry) {
  device::Driver driver;
  driver.scheme = "igtl";
  driver.summary = "optical trackers behind an OpenIGTLink server";
  driver.tracker.emplace();
  driver.tracker->form = "igtl://HOST:PORT of an OpenIGTLink server";
  driver.tracker->names = [](std::string_view uri) { return uri.starts_with("igtl://"); };
  driver.tracker->check = [](const device::TrackerRequest& request) -> Expected<void> {
    if (const auto named = parse_live_tracker(request.uri, request.tools); !named)
      return tl::unexpected(named.error());
    return {};
  };
  driver.tracker->open = open_tracker;
  registry.add(std::move(driver));
}

}  // namespace palpate::drivers::openigtlink
