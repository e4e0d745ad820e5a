// A WebSocket connection to a service, as its client: text messages both ways (RFC 6455).
//
// One thread at a time. No call waits longer than it is told; after one that failed the connection is over. Nothing is
// encrypted: it is for services of this machine. Errors: refused, with the address and what was waited for.
#pragma once

#include <chrono>
#include <cstdint>
#include <memory>
#include <string>
#include <string_view>

#include "palpate/core/expected.h"

namespace palpate::web {

struct WebSocketAddress {
  std::string host = "127.0.0.1";
  std::uint16_t port = 80;
  std::string target = "/";

  std::string text() const;  // ws://HOST:PORT/
};

class WebSocketClient {
 public:
  static constexpr std::size_t kMostBytes =
      1 << 20;  // of a message that comes; a longer one ends the connection

  static Expected<std::unique_ptr<WebSocketClient>> connect(const WebSocketAddress& address,
                                                            std::chrono::nanoseconds at_most);
  virtual ~WebSocketClient() = default;  // closes without waiting for the other side

  virtual Expected<void> send(std::string_view text, std::chrono::nanoseconds at_most) = 0;
  // The next whole message, valid until the next call.
  virtual Expected<std::string_view> receive(std::chrono::nanoseconds at_most) = 0;
};

}  // namespace palpate::web
