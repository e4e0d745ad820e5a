// A small web server for pages of this machine: files that are in the program, and WebSocket connections (RFC 6455).
//
// Written for a browser in which other pages are open. A request is answered only where its header Host names this server
// (a name that somebody has pointed here is refused), and a WebSocket connection only where its Origin is this server's
// own page, one of those allowed, or not said, as by programs that are no browsers. What comes is bounded: header, message,
// connections, time until a request is whole. What goes out is, too: a client that does not read loses messages, the oldest
// first, which are counted, and nobody waits for it. Nothing is encrypted.
//
// One thread: everything happens within serve_for(), the handler's calls among it.
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "palpate/core/expected.h"

namespace palpate::web {

struct WebServerOptions {
  std::string address = "127.0.0.1";  // a number, IPv4 or IPv6
  std::uint16_t port = 0;             // 0 = any that is free
  // Beside the address itself, and localhost where that is a loopback address: what Host may name, without the port.
  std::vector<std::string> hosts{};
  std::vector<std::string> origins{};  // beside the page's own: "https://NAME"
  std::vector<std::string>
      protocols{};  // of WebSocket, that the handler speaks; who asks for none of them is refused
  std::size_t most_clients = 8;                      // WebSocket connections
  std::size_t most_connections = 64;                 // all together
  std::size_t most_bytes_in = 64 * 1024;             // of a message
  std::size_t most_bytes_waiting = 4 * 1024 * 1024;  // for one client
  std::chrono::milliseconds request_within{5000};    // from connecting to the whole request
  std::chrono::milliseconds unread_within{20000};    // a client that takes nothing for so long is cut off
};

// A file of the page; both views live as long as the server.
struct WebFile {
  std::string_view type;  // "text/html; charset=utf-8"
  std::string_view content;
};

// A WebSocket client, from WebHandler::joined() to left(). The messages are shared, as many clients get the same.
class WebPeer {
 public:
  using Bytes = std::shared_ptr<const std::string>;
  virtual ~WebPeer() = default;

  virtual const std::string& protocol() const = 0;  // of WebServerOptions::protocols
  virtual std::string address() const = 0;          // for people
  // The path and what follows it that the client has asked for: "/", "/?a=b".
  virtual const std::string& target() const = 0;

  // What matters by itself: the client is cut off rather than that it is lost.
  virtual void send(Bytes text) = 0;
  // What the next one takes the place of. False: it has not been taken, or an older one has been lost for it.
  virtual bool offer(Bytes message, bool binary) = 0;
  virtual std::uint64_t dropped() const = 0;
  virtual std::size_t bytes_waiting() const = 0;
  // After what waits; no more calls follow but left().
  virtual void close(std::string_view why) = 0;
};

class WebHandler {
 public:
  virtual ~WebHandler() = default;
  // Nothing: there is no such file. `path` begins with '/' and has no query.
  virtual std::optional<WebFile> file(std::string_view path) = 0;
  virtual void joined(WebPeer& peer) = 0;
  virtual void heard(WebPeer& peer, std::string_view bytes, bool binary) = 0;
  virtual void left(WebPeer& peer) = 0;
};

struct WebServerCounters {
  std::uint64_t requests = 0;  // whole ones
  std::uint64_t refused = 0;   // a foreign Host or Origin, no request at all, too large, beyond the numbers
  std::uint64_t dropped = 0;   // messages to those who do not read
  std::uint64_t cut_off = 0;   // clients
};

class WebServer {
 public:
  // `handler` outlives the server. Refused where the address cannot be had; wrong use where it is none.
  static Expected<std::unique_ptr<WebServer>> open(const WebServerOptions& options, WebHandler& handler);
  virtual ~WebServer() = default;  // ends all connections; the handler is not called any more

  virtual std::uint16_t port() const = 0;
  // Returns after this time; never throws.
  virtual void serve_for(std::chrono::nanoseconds time) = 0;
  virtual std::size_t clients() const = 0;  // WebSocket
  virtual WebServerCounters counters() const = 0;
};

}  // namespace palpate::web
