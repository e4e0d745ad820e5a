// The side that sends.
#include <algorithm>
#include <map>

#include "drivers/openigtlink/message_stream.h"
#include "drivers/openigtlink/protocol.h"
#include "palpate/time/clock.h"

namespace palpate::drivers::openigtlink {
namespace {

using network::PublishedPose;
using Bytes = network::SendQueue::Bytes;

// A tool whose pose is older than this has gone out of sight: TDATA has no other way to say so than leaving
// it out.
constexpr std::int64_t kSeenNs = 500'000'000;

std::int64_t clock_ns() { return MonotonicClock<TrackerClock>::monotonic_ns(); }

// The newest poses of all tools, as one message.
class Newest {
 public:
  void keep(const PublishedPose& pose) {
    auto& known = of_tool_[pose.tool];
    if (known.at_ns == pose.at_ns && known.bytes == pose.bytes)
      return;  // another client's turn has brought it
    known = pose;
    message_.reset();
  }

  Bytes message() {
    const std::int64_t now = clock_ns();
    if (std::erase_if(of_tool_, [now](const auto& tool) { return now - tool.second.at_ns > kSeenNs; }) > 0)
      message_.reset();
    if (message_) return message_;
    TrackingData data;
    network::Stamp stamp;
    for (const auto& [name, published] : of_tool_) {
      data.tools.push_back({.name = name, .pose = published.pose});
      if (published.stamp && (!stamp || *published.stamp > *stamp)) stamp = published.stamp;
    }
    auto bytes = encode({"Palpate", stamp, std::move(data)});
    if (bytes) message_ = std::make_shared<const std::string>(std::move(*bytes));
    return message_;
  }

 private:
  std::map<std::string, PublishedPose> of_tool_;
  Bytes message_;  // made for the first client that wants it
};

class Client : public network::ServedClient {
 public:
  explicit Client(Newest* newest) : newest_(newest) {}

  void begin(const Push&) override {}

  void pose(const PublishedPose& pose, const Push& push) override {
    if (newest_ != nullptr) newest_->keep(pose);
    if (!interval_ns_) push(pose.bytes);
  }

  void handed_over(const Push& push) override {
    const std::int64_t now = clock_ns();
    if (newest_ == nullptr || !interval_ns_ || now < due_ns_) return;
    // In step with the clock, not with the poses: at a third of their rate where that is asked for.
    due_ns_ = std::max(due_ns_ + *interval_ns_, now);
    if (auto bytes = newest_->message()) push(std::move(bytes));
  }

  bool take(std::string_view bytes, const Push&) override {
    return stream_.take(bytes, [this](Message&& message) {
      if (newest_ == nullptr) return;
      if (const auto* start = std::get_if<StartTracking>(&message.content)) {
        interval_ns_ = std::int64_t{1'000'000} * std::max(start->resolution_ms, 0);
        due_ns_ = clock_ns();
      } else if (std::holds_alternative<StopTracking>(message.content)) {
        interval_ns_.reset();
      }
    });
  }

 private:
  Newest* newest_;  // none: tracking data are not served
  MessageStream stream_;
  std::optional<std::int64_t> interval_ns_;  // TDATA instead of TRANSFORM
  std::int64_t due_ns_ = 0;
};

class Protocol : public network::PoseProtocol {
 public:
  explicit Protocol(bool tracking_data) : tracking_data_(tracking_data) {}
  Expected<std::string> encode(const std::string& tool, network::Stamp stamp,
                               const RigidPose& pose) override {
    return openigtlink::encode({tool, stamp, Transform{pose}});
  }
  std::unique_ptr<network::ServedClient> meet() override {
    return std::make_unique<Client>(tracking_data_ ? &newest_ : nullptr);
  }

 private:
  const bool tracking_data_;
  Newest newest_;
};

}  // namespace

Expected<std::unique_ptr<network::PoseServer>> listen(const network::Address& address,
                                                      const ServerOptions& options) {
  return network::PoseServer::listen(
      address,
      [&](const network::Address&) -> Expected<std::unique_ptr<network::PoseProtocol>> {
        return std::make_unique<Protocol>(options.tracking_data);
      },
      options.of_any);
}

}  // namespace palpate::drivers::openigtlink
