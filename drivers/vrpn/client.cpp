// The side that listens.
#include <map>

#include "drivers/vrpn/message_stream.h"
#include "drivers/vrpn/protocol.h"
#include "palpate/core/text.h"

namespace palpate::drivers::vrpn {
namespace {

constexpr std::size_t kMostNames = 4096;  // of devices, and of types, that one server introduces

class Listener : public network::Conversation {
 public:
  void begin(std::int64_t, Turn& turn) override { turn.out += cookie(); }

  bool take(std::string_view bytes, std::int64_t now_ns, Turn& turn) override {
    const bool fine = stream_.take(bytes, [&](Message&& message) { hear(message, now_ns, turn); });
    if (!fine) turn.trouble = stream_.complaint();
    return fine;
  }

  Counts counts() const override { return counts_; }

 private:
  void hear(const Message& message, std::int64_t arrived, Turn& turn) {
    if (message.type == kSenderDescription || message.type == kTypeDescription) {
      auto& names = message.type == kSenderDescription ? devices_ : types_;
      auto name = decode_name(message.payload);
      if (!name) return refuse(name.error(), turn);
      if (names.size() < kMostNames) names[message.sender] = std::move(*name);
      return;
    }
    const auto type = types_.find(message.type);
    const auto device = devices_.find(message.sender);
    if (type == types_.end() || type->second != kPoseType || device == devices_.end()) {
      ++counts_.skipped;
      return;
    }
    const auto pose = decode_pose(message.payload);
    if (!pose) return refuse(pose.error(), turn);
    turn.heard.push_back({.tool = tool_name(device->second, pose->sensor),
                          .stamp = message.stamp,
                          .server_time = true,
                          .arrived_ns = arrived,
                          .pose = pose->pose});
  }

  void refuse(const Error& error, Turn& turn) {
    ++counts_.refused;
    turn.trouble = error.message;
  }

  MessageStream stream_;
  std::map<std::int32_t, std::string> devices_, types_;  // by the server's numbers
  Counts counts_;
};

}  // namespace

Expected<std::unique_ptr<network::PoseClient>> connect(const network::Address& server) {
  return network::PoseClient::connect(server, [] { return std::make_unique<Listener>(); });
}

}  // namespace palpate::drivers::vrpn
