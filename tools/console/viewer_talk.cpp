#include "tools/console/viewer_talk.h"

#include <algorithm>
#include <optional>

#include "palpate/core/base64.h"
#include "palpate/core/json.h"
#include "palpate/core/little_endian.h"
#include "palpate/core/text.h"
#include "palpate/record/session/message_schemas.h"

namespace palpate::tools::console {
namespace {

constexpr char kMessageData = 0x01;

std::optional<std::uint32_t> number_of(const Json& json) {
  if (!json.is_number_unsigned() || json.get<std::uint64_t>() > 0xffffffffU) return std::nullopt;
  return json.get<std::uint32_t>();
}

const Json* array_of(const Json& json, const char* key) {
  const auto found = json.find(key);
  return found != json.end() && found->is_array() ? &*found : nullptr;
}

}  // namespace

const std::vector<ViewerChannel>& viewer_channels() {
  static const std::vector<ViewerChannel> channels{{"/physics/state", "palpate.wire.WorldState"},
                                                   {"/tf", "foxglove.FrameTransforms"},
                                                   {"/scene", "foxglove.SceneUpdate"},
                                                   {"/plot", "palpate.recording.Plot"},
                                                   {"/status", "palpate.wire.StatusReply"},
                                                   {"/log", "foxglove.Log"},
                                                   {"/graphics/picture", "foxglove.CompressedImage"}};
  return channels;
}

std::vector<std::string> ViewerTalk::greeting(const std::string& application) {
  Json channels = Json::array();
  std::uint32_t number = 0;
  for (const auto& channel : viewer_channels()) {
    const auto schema = record::session::schema_of(channel.message);
    channels.push_back({{"id", ++number},
                        {"topic", channel.topic},
                        {"encoding", "protobuf"},
                        {"schemaName", channel.message},
                        {"schema", base64(schema.data)},
                        {"schemaEncoding", "protobuf"}});
  }
  const Json info{{"op", "serverInfo"},
                  {"name", "Palpate" + (application.empty() ? "" : ": " + excerpt(application, 64))},
                  {"capabilities", Json::array()},
                  {"metadata", Json::object()}};
  const auto text = [](const Json& json) {
    return json.dump(-1, ' ', false, Json::error_handler_t::replace);
  };
  return {text(info), text({{"op", "advertise"}, {"channels", std::move(channels)}})};
}

Expected<void> ViewerTalk::take(std::string_view text) {
  const Json json = Json::parse(text, nullptr, false);
  if (!json.is_object() || !json.contains("op") || !json["op"].is_string())
    return refused("a JSON object with an \"op\" is expected");
  const auto op = json["op"].get<std::string>();
  if (op == "subscribe") {
    const Json* wanted = array_of(json, "subscriptions");
    if (wanted == nullptr) return refused("subscribe: \"subscriptions\" is expected");
    for (const Json& one : *wanted) {
      if (!one.is_object()) return refused("subscribe: objects with \"id\" and \"channelId\" are expected");
      const auto id = number_of(one.value("id", Json())), channel = number_of(one.value("channelId", Json()));
      if (!id || !channel || *channel < 1 || *channel > viewer_channels().size())
        return refused("subscribe: a known channel is expected, 1 to {}", viewer_channels().size());
      if (subscriptions_.size() >= kMostSubscriptions)
        return refused("subscribe: {} subscriptions are as many as there may be; remove some",
                       kMostSubscriptions);
      subscriptions_[*id] = *channel;
    }
    return {};
  }
  if (op == "unsubscribe") {
    const Json* ids = array_of(json, "subscriptionIds");
    if (ids == nullptr) return refused("unsubscribe: \"subscriptionIds\" is expected");
    for (const Json& one : *ids)
      if (const auto id = number_of(one)) subscriptions_.erase(*id);
    return {};
  }
  return refused("\"{}\" is not served here; expected: subscribe, unsubscribe", excerpt(op, 40));
}

bool ViewerTalk::wants(Channel channel) const {
  return std::any_of(subscriptions_.begin(), subscriptions_.end(), [&](const auto& subscription) {
    return subscription.second == static_cast<std::uint32_t>(channel);
  });
}

std::vector<std::string> ViewerTalk::wrap(Channel channel, std::uint64_t time_ns,
                                          std::string_view message) const {
  std::vector<std::string> wrapped;
  for (const auto& [id, subscribed] : subscriptions_) {
    if (subscribed != static_cast<std::uint32_t>(channel)) continue;
    std::string bytes(1, kMessageData);
    append_little_endian(bytes, id);
    append_little_endian(bytes, time_ns);
    bytes += message;
    wrapped.push_back(std::move(bytes));
  }
  return wrapped;
}

std::string ViewerTalk::status_text(const std::string& words) {
  return Json{{"op", "status"}, {"level", 1}, {"message", words}}.dump(-1, ' ', false,
                                                                       Json::error_handler_t::replace);
}

}  // namespace palpate::tools::console
