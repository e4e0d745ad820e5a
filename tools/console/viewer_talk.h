// The protocol of common viewers (Lichtblick, Foxglove), as a server: channels with their schemas, and what one has
// subscribed to. Written from the public description: github.com/foxglove/ws-protocol, docs/spec.md before its repository
// was closed (subprotocol foxglove.websocket.v1); foxglove.sdk.v1 is the same under another name.
//
// One object for each client. Knows no socket: it says what is to be sent. One thread.
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "palpate/core/expected.h"

namespace palpate::tools::console {

inline constexpr const char* kViewerProtocols[] = {"foxglove.websocket.v1", "foxglove.sdk.v1"};

struct ViewerChannel {
  std::string topic, message;  // "/tf", "foxglove.FrameTransforms"
};
// Channel 1, 2, ... in their order; the same topics as in a recording where it is the same.
const std::vector<ViewerChannel>& viewer_channels();
enum class Channel : std::uint32_t { state = 1, frames, scene, plot, status, log, picture };

class ViewerTalk {
 public:
  static constexpr std::size_t kMostSubscriptions = 256;

  // What a client is told first: texts, in this order.
  static std::vector<std::string> greeting(const std::string& application);

  // A text of the client's. An error in it is told (`status_text` of it) and harms nothing.
  Expected<void> take(std::string_view text);

  bool wants(Channel channel) const;
  // A message of the channel, once for each subscription: what is to be sent, as bytes.
  std::vector<std::string> wrap(Channel channel, std::uint64_t time_ns, std::string_view message) const;

  static std::string status_text(const std::string& words);

 private:
  std::map<std::uint32_t, std::uint32_t> subscriptions_;  // their number: the channel's
};

}  // namespace palpate::tools::console
