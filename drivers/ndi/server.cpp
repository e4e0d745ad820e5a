// The side that sends: answers as a tracker does.
#include <algorithm>
#include <mutex>

#include "drivers/ndi/internal/limits.h"
#include "drivers/ndi/internal/simulated_device.h"
#include "drivers/ndi/protocol.h"
#include "palpate/core/text.h"
#include "palpate/time/clock.h"

namespace palpate::drivers::ndi {
namespace {

std::int64_t clock_ns() { return MonotonicClock<TrackerClock>::monotonic_ns(); }

// The tools there are. Any thread.
class Tools {
 public:
  // Refused beyond kMostServed.
  Expected<void> add(const std::string& tool) {
    const std::lock_guard lock(mutex_);
    if (std::find(names_.begin(), names_.end(), tool) != names_.end()) return {};
    if (names_.size() >= kMostServed) return refused("more than {} tools cannot be served", kMostServed);
    names_.push_back(tool);
    return {};
  }
  std::vector<std::string> names() const {
    const std::lock_guard lock(mutex_);
    return names_;
  }

 private:
  mutable std::mutex mutex_;
  std::vector<std::string> names_;
};

class Client : public network::ServedClient {
 public:
  Client(const Tools& tools, bool timestamps) : tools_(tools), device_(timestamps) {}

  void begin(const Push&) override {}

  void pose(const network::PublishedPose& pose, const Push&) override { device_.pose(pose); }

  // Text alone comes from a client, a line for each command.
  bool take(std::string_view bytes, const Push& push) override {
    for (const char byte : bytes) {
      if (byte == '\r') {
        push(std::make_shared<const std::string>(answer_to(line_)));
        line_.clear();
      } else if (byte < ' ' || byte > '~' || line_.size() > kMostCommand) {
        return false;
      } else {
        line_ += byte;
      }
    }
    return true;
  }

  bool has_more() const override { return device_.has_more(); }

 private:
  std::string answer_to(std::string_view line) {
    const auto command = decode_command(line);
    if (!command) return encode_error(command.error());
    if (command->name == "INIT")
      for (const auto& tool : tools_.names()) device_.plug_in(tool);
    return device_.answer(*command, clock_ns());
  }

  const Tools& tools_;
  SimulatedDevice device_;
  std::string line_;
};

class Protocol : public network::PoseProtocol {
 public:
  explicit Protocol(bool timestamps) : timestamps_(timestamps) {}

  Expected<void> add(const std::string& tool) {
    const bool letters = std::all_of(tool.begin(), tool.end(), [](char c) { return c >= ' ' && c <= '~'; });
    if (tool.empty() || tool.size() > kMostNameBytes || !letters)
      return refused("a tool of an NDI tracker has a name of 1 to {} letters of ASCII, not '{}'",
                     kMostNameBytes, excerpt(tool));
    return tools_.add(tool);
  }

  // Nothing is sent before a client asks: what makes bytes of a pose is the client's device.
  Expected<std::string> encode(const std::string& tool, network::Stamp stamp,
                               const network::RigidPose& pose) override {
    constexpr double kLatest = 4294967295.0;  // s, of 32 bits
    if (!pose.translation.allFinite() || pose.translation.cwiseAbs().maxCoeff() > kFarthest ||
        !(std::abs(pose.rotation.norm() - 1.0) < 1e-6))
      return refused("{}: the pose to send is not rigid or not within {:g} m; a unit quaternion is expected",
                     excerpt(tool), kFarthest);
    if (stamp && (stamp->ns() < 0 || stamp->seconds() > kLatest))
      return refused("a stamp of {:.0f} s cannot be written for an NDI tracker; 0 to {:.0f} s is expected",
                     stamp->seconds(), kLatest);
    if (auto added = add(tool); !added) return tl::unexpected(added.error());
    return std::string();
  }
  std::unique_ptr<network::ServedClient> meet() override {
    return std::make_unique<Client>(tools_, timestamps_);
  }

 private:
  const bool timestamps_;
  Tools tools_;
};

}  // namespace

Expected<std::unique_ptr<network::PoseServer>> listen(const network::Address& address,
                                                      const ServerOptions& options) {
  return network::PoseServer::listen(
      address,
      [&](const network::Address&) -> Expected<std::unique_ptr<network::PoseProtocol>> {
        auto protocol = std::make_unique<Protocol>(options.timestamps);
        for (const auto& tool : options.tools)
          if (auto added = protocol->add(tool); !added) return tl::unexpected(added.error());
        return protocol;
      },
      options.of_any);
}

}  // namespace palpate::drivers::ndi
