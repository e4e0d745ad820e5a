// The side that sends.
#include <arpa/inet.h>
#include <netinet/in.h>
#include <sys/socket.h>

#include <charconv>
#include <cstring>
#include <map>
#include <mutex>
#include <vector>

#include "drivers/network/socket.h"
#include "drivers/vrpn/message_stream.h"
#include "drivers/vrpn/protocol.h"
#include "palpate/core/system_error.h"
#include "palpate/core/text.h"
#include "palpate/time/clock.h"

namespace palpate::drivers::vrpn {
namespace {

using Bytes = network::SendQueue::Bytes;

enum Type : std::int32_t { pose_type, ping_type, pong_type };
constexpr const char* kTypes[] = {kPoseType, kPingType, kPongType};
constexpr std::size_t kMostTools = 1024, kMostOfClient = 4096, kMostEarly = 256;

Instant<TrackerClock> now() {
  return Instant<TrackerClock>{Duration(MonotonicClock<TrackerClock>::monotonic_ns())};
}

Bytes introduction(std::int32_t kind, std::int32_t number, std::string_view name) {
  return std::make_shared<const std::string>(*encode({now(), number, kind, encode_name(name)}));
}

// The devices there are, by number. Any thread.
class Devices {
 public:
  // Refused beyond kMostTools.
  Expected<std::int32_t> number_of(const std::string& tool) {
    const std::lock_guard lock(mutex_);
    if (const auto known = numbers_.find(tool); known != numbers_.end()) return known->second;
    if (names_.size() >= kMostTools) return refused("more than {} tools cannot be served", kMostTools);
    const auto number = static_cast<std::int32_t>(names_.size());
    names_.push_back(tool);
    numbers_.emplace(tool, number);
    return number;
  }
  // Those from the number `first` on.
  std::vector<std::string> names_from(std::size_t first) const {
    const std::lock_guard lock(mutex_);
    return {names_.begin() + static_cast<std::ptrdiff_t>(std::min(first, names_.size())), names_.end()};
  }
  std::optional<std::int32_t> find(const std::string& tool) const {
    const std::lock_guard lock(mutex_);
    const auto known = numbers_.find(tool);
    return known == numbers_.end() ? std::nullopt : std::optional(known->second);
  }

 private:
  mutable std::mutex mutex_;
  std::vector<std::string> names_;
  std::map<std::string, std::int32_t> numbers_;
};

class Client : public network::ServedClient {
 public:
  explicit Client(const Devices& devices) : devices_(devices) {}

  void begin(const Push& push) override { push(std::make_shared<const std::string>(cookie())); }

  void pose(const network::PublishedPose& pose, const Push& push) override {
    if (!stream_.greeted()) {
      // Whoever serves a recording begins with the first client, whose version may be on its way.
      if (early_.size() < kMostEarly) early_.push_back(pose.bytes);
      return;
    }
    introduce(push);
    push(pose.bytes);
  }

  bool has_more() const override { return !early_.empty(); }

  bool take(std::string_view bytes, const Push& push) override {
    const bool fine = stream_.take(bytes, [&](Message&& message) {
      introduce(push);
      hear(message, push);
    });
    if (stream_.greeted()) {
      introduce(push);
      for (auto& early : early_) push(std::move(early));
      early_.clear();
    }
    return fine;
  }

 private:
  // The types, and devices that have come since.
  void introduce(const Push& push) {
    for (; types_introduced_ < std::size(kTypes); ++types_introduced_)
      push(introduction(kTypeDescription, static_cast<std::int32_t>(types_introduced_),
                        kTypes[types_introduced_]));
    for (const auto& name : devices_.names_from(introduced_))
      push(introduction(kSenderDescription, static_cast<std::int32_t>(introduced_++), name));
  }

  // A client asks again and again whether a device is there.
  void hear(const Message& message, const Push& push) {
    if (message.type == kSenderDescription || message.type == kTypeDescription) {
      auto& names = message.type == kSenderDescription ? its_devices_ : its_types_;
      if (auto name = decode_name(message.payload); name && names.size() < kMostOfClient)
        names[message.sender] = std::move(*name);
      return;
    }
    const auto type = its_types_.find(message.type);
    const auto device = its_devices_.find(message.sender);
    if (type == its_types_.end() || type->second != kPingType || device == its_devices_.end()) return;
    const auto number = devices_.find(device->second);
    if (!number || static_cast<std::size_t>(*number) >= introduced_) return;
    push(std::make_shared<const std::string>(*encode({now(), *number, pong_type, ""})));
  }

  const Devices& devices_;
  MessageStream stream_;
  std::vector<Bytes> early_;                           // poses that came before the client's version
  std::size_t introduced_ = 0, types_introduced_ = 0;  // devices, types
  std::map<std::int32_t, std::string> its_devices_, its_types_;  // by the client's numbers
};

// A datagram "HOST PORT": its sender waits there for a connection.
class Requests {
 public:
  static Expected<FileDescriptor> open(const network::Address& address) {
    const auto where = network::resolve(address);
    if (!where) return tl::unexpected(where.error());
    const auto& at = where->front();
    FileDescriptor socket(::socket(at.storage.ss_family, SOCK_DGRAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0));
    if (!socket || ::bind(socket.get(), reinterpret_cast<const sockaddr*>(&at.storage), at.size) != 0)
      return refused(
          "{}: no datagrams can be listened to there ({}); stop the other server or choose another port",
          address.text(), reason_of(errno));
    return socket;
  }

  // Where the sender of the next datagram listens: its own address, whatever host it names.
  static std::optional<network::SocketAddress> next(const FileDescriptor& socket) {
    char text[256];
    network::SocketAddress from;
    from.size = sizeof from.storage;
    const ssize_t count = ::recvfrom(socket.get(), text, sizeof text, 0,
                                     reinterpret_cast<sockaddr*>(&from.storage), &from.size);
    if (count <= 0) return std::nullopt;
    std::string_view words(text, static_cast<std::size_t>(count));
    words = words.substr(0, words.find('\0'));
    const auto blank = words.rfind(' ');
    if (blank == std::string_view::npos) return std::nullopt;
    std::uint16_t port = 0;
    const auto number = words.substr(blank + 1);
    const auto [end, code] = std::from_chars(number.data(), number.data() + number.size(), port);
    constexpr std::uint16_t kFirstOfUsers = 1024;
    if (code != std::errc() || end != number.data() + number.size() || port < kFirstOfUsers)
      return std::nullopt;
    if (from.storage.ss_family == AF_INET)
      reinterpret_cast<sockaddr_in*>(&from.storage)->sin_port = htons(port);
    else
      reinterpret_cast<sockaddr_in6*>(&from.storage)->sin6_port = htons(port);
    return from;
  }
};

class Protocol : public network::PoseProtocol {
 public:
  explicit Protocol(FileDescriptor requests) : requests_(std::move(requests)) {}

  Expected<std::string> encode(const std::string& tool, network::Stamp stamp,
                               const network::RigidPose& pose) override {
    if (tool.empty() || tool.size() > kMostNameBytes)
      return refused("a tool of VRPN has a name of 1 to {} letters, not '{}'", kMostNameBytes, excerpt(tool));
    if (!pose.translation.allFinite() || !pose.rotation.coeffs().allFinite())
      return refused("{}: a pose that is not finite cannot be sent", excerpt(tool));
    const auto number = devices_.number_of(tool);
    if (!number) return tl::unexpected(number.error());
    return vrpn::encode({stamp.value_or(now()), *number, pose_type, encode_pose({0, pose})});
  }
  std::unique_ptr<network::ServedClient> meet() override { return std::make_unique<Client>(devices_); }
  int asking_fd() const override { return requests_.get(); }
  FileDescriptor asked() override {
    const auto to = Requests::next(requests_);
    return to ? network::begin_connect(*to) : FileDescriptor();
  }

 private:
  FileDescriptor requests_;
  Devices devices_;
};

}  // namespace

Expected<std::unique_ptr<network::PoseServer>> listen(const network::Address& address,
                                                      const network::PoseServerOptions& options) {
  return network::PoseServer::listen(
      address,
      [](const network::Address& at) -> Expected<std::unique_ptr<network::PoseProtocol>> {
        auto requests = Requests::open(at);
        if (!requests) return tl::unexpected(requests.error());
        return std::make_unique<Protocol>(std::move(*requests));
      },
      options);
}

}  // namespace palpate::drivers::vrpn
