#include "palpate/web/web_server.h"

#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <sys/socket.h>

#include <chrono>
#include <string>
#include <vector>

#include "palpate/core/file_descriptor.h"

namespace palpate::web {
namespace {

using namespace std::chrono_literals;

// Serves one file, and says every message back.
class Echo final : public WebHandler {
 public:
  std::optional<WebFile> file(std::string_view path) override {
    return path == "/" ? std::optional(WebFile{"text/html", "<p>here"}) : std::nullopt;
  }
  void joined(WebPeer& peer) override { peers.push_back(&peer); }
  void heard(WebPeer& peer, std::string_view bytes, bool binary) override {
    got.emplace_back(bytes);
    if (bytes == "bye") return peer.close("asked to");
    peer.offer(std::make_shared<const std::string>(bytes), binary);
  }
  void left(WebPeer& peer) override {
    ++gone;
    std::erase(peers, &peer);
  }

  std::vector<WebPeer*> peers;
  std::vector<std::string> got;
  int gone = 0;
};

// A peer of one's own, which writes and reads bytes; nothing of Beast.
class Peer {
 public:
  Peer(WebServer& server, std::uint16_t port) : server_(server), socket_(::socket(AF_INET, SOCK_STREAM, 0)) {
    sockaddr_in place{};
    place.sin_family = AF_INET;
    place.sin_port = htons(port);
    ::inet_pton(AF_INET, "127.0.0.1", &place.sin_addr);
    ended_ = ::connect(socket_.get(), reinterpret_cast<sockaddr*>(&place), sizeof place) != 0;
    server_.serve_for(200us);  // nobody else accepts
  }

  void say(std::string_view bytes) { ::send(socket_.get(), bytes.data(), bytes.size(), MSG_NOSIGNAL); }
  // What has come until `end` is in it, the connection has ended, or a second has passed.
  std::string hear(std::string_view end) {
    for (int i = 0; i < 200 && !ended_ && heard_.find(end) == std::string::npos; ++i) {
      server_.serve_for(5ms);
      char bytes[65536];
      for (ssize_t n; (n = ::recv(socket_.get(), bytes, sizeof bytes, MSG_DONTWAIT)) >= 0;) {
        if (n == 0) {
          ended_ = true;
          break;
        }
        heard_.append(bytes, static_cast<std::size_t>(n));
      }
    }
    return std::exchange(heard_, {});
  }
  bool ended() {
    hear("\x01nothing like this comes");
    return ended_;
  }
  // The status line of the answer.
  std::string get(const std::string& path, const std::string& headers) {
    say("GET " + path + " HTTP/1.1\r\n" + headers + "\r\n");
    const auto answer = hear("\r\n\r\n");
    return answer.substr(0, answer.find("\r\n"));
  }
  std::string upgrade(const std::string& headers) {
    return get("/live?a=b",
               "Connection: Upgrade\r\nUpgrade: websocket\r\nSec-WebSocket-Version: 13\r\nSec-WebSocket-Key: "
               "dGhlIHNhbXBsZSBub25jZQ==\r\n" +
                   headers);
  }
  // A masked text frame of less than 64 KiB.
  void send_text(const std::string& text) {
    std::string frame = "\x81";
    if (text.size() < 126) {
      frame += static_cast<char>(0x80 | text.size());
    } else {
      frame += '\xfe';
      frame += static_cast<char>(text.size() >> 8);
      frame += static_cast<char>(text.size() & 0xff);
    }
    frame += std::string(4, '\0');
    say(frame + text);
  }

 private:
  WebServer& server_;
  FileDescriptor socket_;
  std::string heard_;
  bool ended_ = false;
};

struct WebServerRig : ::testing::Test {
  std::unique_ptr<WebServer> open(WebServerOptions options = {}) {
    options.protocols = {"echo.v1"};
    auto server = WebServer::open(options, handler);
    EXPECT_TRUE(server) << server.error().message;
    return std::move(*server);
  }
  static constexpr const char* kHost = "Host: localhost\r\n";
  static constexpr const char* kEcho = "Sec-WebSocket-Protocol: other, echo.v1\r\n";
  Echo handler;
};

TEST_F(WebServerRig, GivesItsFilesAndNoOthers) {
  const auto server = open();
  Peer peer(*server, server->port());
  peer.say("GET /?x=1 HTTP/1.1\r\nHost: 127.0.0.1:80\r\n\r\n");
  const auto answer = peer.hear("<p>here");
  EXPECT_NE(answer.find("200 OK"), std::string::npos) << answer;
  EXPECT_NE(answer.find("Content-Security-Policy: default-src 'self'"), std::string::npos) << answer;
  EXPECT_NE(answer.find("<p>here"), std::string::npos) << answer;
  // The connection goes on.
  EXPECT_EQ(peer.get("/../../etc/passwd", kHost), "HTTP/1.1 404 Not Found");
  Peer other(*server, server->port());
  other.say("POST / HTTP/1.1\r\nHost: localhost\r\nContent-Length: 0\r\n\r\n");
  EXPECT_NE(other.hear("\r\n\r\n").find("405"), std::string::npos);
}

TEST_F(WebServerRig, RefusesAForeignHostAndOrigin) {
  const auto server = open();
  const auto asked = [&](const std::string& headers) {
    return Peer(*server, server->port()).upgrade(headers).substr(9, 3);
  };
  EXPECT_EQ(Peer(*server, server->port()).get("/", "Host: evil.example\r\n").substr(9, 3), "421");
  EXPECT_EQ(Peer(*server, server->port()).get("/", "").substr(9, 3), "421");
  EXPECT_EQ(asked(std::string("Host: evil.example\r\nOrigin: http://evil.example\r\n") + kEcho), "421");
  EXPECT_EQ(asked(std::string(kHost) + "Origin: http://evil.example\r\n" + kEcho), "403");
  EXPECT_EQ(asked(std::string(kHost) + "Origin: null\r\n" + kEcho), "403");
  EXPECT_EQ(asked(kHost), "400");  // no protocol
  EXPECT_EQ(asked(std::string(kHost) + "Sec-WebSocket-Protocol: other\r\n"), "400");
  EXPECT_EQ(server->counters().refused, 7u);
  EXPECT_TRUE(handler.peers.empty());
  EXPECT_EQ(asked(std::string(kHost) + "Origin: http://localhost\r\n" + kEcho), "101");
}

TEST_F(WebServerRig, CarriesMessagesBothWays) {
  const auto server = open();
  Peer peer(*server, server->port());
  peer.say(
      "GET /live?a=b HTTP/1.1\r\nHost: localhost\r\nConnection: Upgrade\r\nUpgrade: "
      "websocket\r\nSec-WebSocket-Version: "
      "13\r\nSec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\nSec-WebSocket-Protocol: echo.v1\r\n\r\n");
  const auto answer = peer.hear("\r\n\r\n");
  // The example of RFC 6455, section 1.3.
  EXPECT_NE(answer.find("Sec-WebSocket-Accept: s3pPLMBiTxaQ9kYGzzhZRbK+xOo="), std::string::npos) << answer;
  EXPECT_NE(answer.find("Sec-WebSocket-Protocol: echo.v1"), std::string::npos) << answer;
  ASSERT_EQ(handler.peers.size(), 1u);
  EXPECT_EQ(handler.peers[0]->protocol(), "echo.v1");
  EXPECT_EQ(handler.peers[0]->target(), "/live?a=b");
  peer.send_text("hello");
  EXPECT_EQ(peer.hear("hello"), std::string("\x81\x05hello"));
  peer.send_text("bye");
  EXPECT_NE(peer.hear("asked to").find("asked to"), std::string::npos);
}

TEST_F(WebServerRig, EndsAConnectionWithAMessageThatIsTooLarge) {
  WebServerOptions options;
  options.most_bytes_in = 1000;
  const auto server = open(options);
  {
    Peer peer(*server, server->port());
    ASSERT_EQ(peer.upgrade(std::string(kHost) + kEcho).substr(9, 3), "101");
    peer.send_text(std::string(1000, 'a'));
    EXPECT_NE(peer.hear("aaaa").find("aaaa"), std::string::npos);
    peer.send_text(std::string(1001, 'b'));
    EXPECT_TRUE(peer.ended());
  }
  server->serve_for(50ms);
  EXPECT_EQ(handler.got.size(), 1u);
  EXPECT_EQ(handler.gone, 1);
  EXPECT_EQ(server->counters().refused, 1u);
}

TEST_F(WebServerRig, HasRoomForSoManyAndNoMore) {
  WebServerOptions options;
  options.most_clients = 2;
  options.most_connections = 4;
  const auto server = open(options);
  std::vector<std::unique_ptr<Peer>> peers;
  for (const char* code : {"101", "101", "503"}) {
    peers.push_back(std::make_unique<Peer>(*server, server->port()));
    EXPECT_EQ(peers.back()->upgrade(std::string(kHost) + kEcho).substr(9, 3), code);
  }
  // A hundred who say nothing: two have a place, until their time is over.
  for (int i = 0; i < 100; ++i) peers.push_back(std::make_unique<Peer>(*server, server->port()));
  EXPECT_TRUE(peers.back()->ended());
  EXPECT_GE(server->counters().refused, 98u);
  EXPECT_EQ(handler.peers.size(), 2u);
  peers[0]->send_text("still here");
  EXPECT_NE(peers[0]->hear("still here").find("still here"), std::string::npos);
  peers.clear();
  server->serve_for(20ms);
  EXPECT_EQ(server->clients(), 0u);
  EXPECT_EQ(Peer(*server, server->port()).upgrade(std::string(kHost) + kEcho).substr(9, 3), "101");
}

TEST_F(WebServerRig, WaitsForARequestOnlySoLong) {
  WebServerOptions options;
  options.request_within = 50ms;
  const auto server = open(options);
  Peer peer(*server, server->port());
  peer.say("GET / HTT");
  EXPECT_TRUE(peer.ended());
  Peer flood(*server, server->port());
  flood.say("GET / HTTP/1.1\r\nX: " + std::string(20'000, 'x'));
  EXPECT_TRUE(flood.ended());
}

TEST_F(WebServerRig, LosesTheOldestForAClientThatDoesNotRead) {
  WebServerOptions options;
  options.most_bytes_waiting = 1 << 20;
  options.unread_within = 1000ms;
  const auto server = open(options);
  Peer peer(*server, server->port());
  ASSERT_EQ(peer.upgrade(std::string(kHost) + kEcho).substr(9, 3), "101");
  ASSERT_EQ(handler.peers.size(), 1u);
  const auto message = std::make_shared<const std::string>(100'000, 'x');
  bool all_taken = true;
  for (int i = 0; i < 400 && !handler.peers.empty(); ++i) {
    all_taken = handler.peers[0]->offer(message, true) && all_taken;
    EXPECT_LE(handler.peers[0]->bytes_waiting(), options.most_bytes_waiting + message->size());
    server->serve_for(100us);
  }
  EXPECT_FALSE(all_taken);
  EXPECT_GT(server->counters().dropped, 100u);
  for (int i = 0; i < 1000 && !handler.peers.empty(); ++i) server->serve_for(10ms);
  EXPECT_TRUE(handler.peers.empty());  // and is cut off in the end
  EXPECT_EQ(server->counters().cut_off, 1u);
}

TEST_F(WebServerRig, SaysWhyAnAddressCannotBeHad) {
  const auto first = open();
  WebServerOptions options;
  options.port = first->port();
  const auto taken = WebServer::open(options, handler);
  ASSERT_FALSE(taken);
  EXPECT_NE(taken.error().message.find("check what listens there"), std::string::npos)
      << taken.error().message;
  options.address = "not a number";
  const auto wrong = WebServer::open(options, handler);
  ASSERT_FALSE(wrong);
  EXPECT_NE(wrong.error().message.find("a number is expected"), std::string::npos) << wrong.error().message;
}

}  // namespace
}  // namespace palpate::web
