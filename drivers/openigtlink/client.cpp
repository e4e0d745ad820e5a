// The side that listens.
#include "drivers/openigtlink/message_stream.h"
#include "drivers/openigtlink/protocol.h"
#include "palpate/core/text.h"

namespace palpate::drivers::openigtlink {
namespace {

constexpr std::int64_t kSilenceNs = 500'000'000;
constexpr std::uint16_t kAllIsWell = 1;  // of STATUS

class Listener : public network::Conversation {
 public:
  explicit Listener(const ClientOptions& options) : options_(options) {}

  void begin(std::int64_t now_ns, Turn&) override {
    if (options_.start == StartRequest::never) return;
    ask_at_ = now_ns + (options_.start == StartRequest::at_once ? 0 : kSilenceNs);
  }

  bool take(std::string_view bytes, std::int64_t now_ns, Turn& turn) override {
    const bool fine = stream_.take(bytes, [&](Message&& message) { hear(std::move(message), now_ns, turn); });
    if (!stream_.complaint().empty()) turn.trouble = stream_.complaint();
    return fine;
  }

  std::optional<std::int64_t> due_ns() const override { return heard_pose_ ? std::nullopt : ask_at_; }

  bool ask(std::int64_t, Turn& turn) override {
    ask_at_.reset();
    asked_ = true;
    send(StartTracking{options_.period_ms, ""}, turn);
    return true;
  }

  void end(Turn& turn) override {
    if (asked_) send(StopTracking{}, turn);
  }

  Counts counts() const override {
    const auto& counts = stream_.counts();
    return {counts.bad_crc, counts.refused, counts.skipped};
  }

 private:
  static void send(Content content, Turn& turn) {
    if (const auto bytes = encode({"", {}, std::move(content)})) turn.out += *bytes;
  }

  void hear(Message&& message, std::int64_t arrived, Turn& turn) {
    network::ToolSample sample;
    sample.arrived_ns = arrived;
    sample.server_time = message.stamp.has_value();
    sample.stamp = message.stamp.value_or(Instant<TrackerClock>{Duration(arrived)});
    if (const auto* transform = std::get_if<Transform>(&message.content)) {
      sample.tool = std::move(message.device);
      sample.seen = transform->valid;
      sample.pose = transform->pose;
      keep(sample, turn);
    } else if (auto* data = std::get_if<TrackingData>(&message.content)) {
      for (auto& tool : data->tools) {
        sample.tool = std::move(tool.name);
        sample.pose = tool.pose;
        keep(sample, turn);
      }
    } else if (const auto* status = std::get_if<Status>(&message.content);
               status && status->code != kAllIsWell) {
      turn.trouble = fmt::format("the server says: status {} {} {}", status->code, status->name,
                                 excerpt(status->text, 120));
    }
  }

  void keep(const network::ToolSample& sample, Turn& turn) {
    heard_pose_ = true;
    turn.heard.push_back(sample);
  }

  const ClientOptions options_;
  MessageStream stream_;
  std::optional<std::int64_t> ask_at_;
  bool heard_pose_ = false, asked_ = false;
};

}  // namespace

Expected<std::unique_ptr<network::PoseClient>> connect(const network::Address& server,
                                                       const ClientOptions& options) {
  return network::PoseClient::connect(server, [options] { return std::make_unique<Listener>(options); });
}

}  // namespace palpate::drivers::openigtlink
