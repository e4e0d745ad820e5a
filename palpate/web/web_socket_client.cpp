#include "palpate/web/web_socket_client.h"

#include <boost/asio/connect.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/beast/core.hpp>
#include <boost/beast/websocket.hpp>
#include <optional>

#include "palpate/core/text.h"

namespace palpate::web {
namespace {

namespace beast = boost::beast;
using tcp = boost::asio::ip::tcp;
using Failure = boost::system::error_code;

class BeastClient final : public WebSocketClient {
 public:
  explicit BeastClient(const WebSocketAddress& address) : address_(address), stream_(context_) {}
  ~BeastClient() override {
    Failure ignored;
    beast::get_lowest_layer(stream_).socket().close(ignored);
  }

  Expected<void> open(std::chrono::nanoseconds at_most) {
    Failure failure;
    tcp::resolver resolver(context_);
    const auto found = resolver.resolve(address_.host, std::to_string(address_.port), failure);
    if (failure)
      return refused("{}: the host is not known ({}); check the address", address_.text(), failure.message());
    auto& tcp_stream = beast::get_lowest_layer(stream_);
    auto done = wait("connecting", at_most, [&](auto finished) {
      tcp_stream.async_connect(found, [finished](Failure f, const tcp::endpoint&) { finished(f); });
    });
    if (!done) return done;
    tcp_stream.socket().set_option(tcp::no_delay(true), failure);
    stream_.read_message_max(kMostBytes);
    stream_.text(true);
    return wait("the handshake", at_most, [&](auto finished) {
      stream_.async_handshake(address_.host + ":" + std::to_string(address_.port), address_.target,
                              [finished](Failure f) { finished(f); });
    });
  }

  Expected<void> send(std::string_view text, std::chrono::nanoseconds at_most) override {
    return wait("sending", at_most, [&](auto finished) {
      stream_.async_write(boost::asio::const_buffer(text.data(), text.size()),
                          [finished](Failure f, std::size_t) { finished(f); });
    });
  }

  Expected<std::string_view> receive(std::chrono::nanoseconds at_most) override {
    message_.clear();
    const auto done = wait("an answer", at_most, [&](auto finished) {
      stream_.async_read(message_, [finished](Failure f, std::size_t) { finished(f); });
    });
    if (!done) return tl::unexpected(done.error());
    if (!stream_.got_text()) return refused("{}: a message of bytes came; text is expected", address_.text());
    return std::string_view(static_cast<const char*>(message_.data().data()), message_.size());
  }

 private:
  // Runs one operation to its end, or gives it up. It holds references to what lives here, so that an operation that was
  // given up is still run to its end.
  template <typename Start>
  Expected<void> wait(const char* what, std::chrono::nanoseconds at_most, Start&& start) {
    std::optional<Failure> outcome;
    start([&outcome](Failure f) { outcome = f; });
    context_.restart();
    context_.run_for(at_most);
    if (!outcome) {
      beast::get_lowest_layer(stream_).cancel();
      context_.restart();
      context_.run();
      return refused("{}: {} took longer than {} ms; check that the service runs", address_.text(), what,
                     std::chrono::duration_cast<std::chrono::milliseconds>(at_most).count());
    }
    if (*outcome)
      return refused("{}: {} failed ({}); check that the service runs there", address_.text(), what,
                     one_line(outcome->message()));
    return {};
  }

  WebSocketAddress address_;
  boost::asio::io_context context_;
  beast::websocket::stream<beast::tcp_stream> stream_;
  beast::flat_buffer message_;
};

}  // namespace

std::string WebSocketAddress::text() const {
  return host.find(':') == std::string::npos ? fmt::format("ws://{}:{}{}", host, port, target)
                                             : fmt::format("ws://[{}]:{}{}", host, port, target);
}

Expected<std::unique_ptr<WebSocketClient>> WebSocketClient::connect(const WebSocketAddress& address,
                                                                    std::chrono::nanoseconds at_most) {
  auto client = std::make_unique<BeastClient>(address);
  if (auto opened = client->open(at_most); !opened) return tl::unexpected(opened.error());
  return client;
}

}  // namespace palpate::web
