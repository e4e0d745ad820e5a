#include "palpate/web/web_server.h"

#include <fmt/format.h>

#include <algorithm>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/post.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/beast/core.hpp>
#include <boost/beast/http.hpp>
#include <boost/beast/websocket.hpp>
#include <deque>
#include <set>

#include "palpate/core/text.h"
#include "palpate/web/web_guard.h"

namespace palpate::web {
namespace {

namespace beast = boost::beast;
namespace http = boost::beast::http;
using tcp = boost::asio::ip::tcp;
using Failure = boost::system::error_code;
using Request = http::request<http::string_body>;
using Text = std::string_view;

Text view(beast::string_view text) { return {text.data(), text.size()}; }

// What all connections need of their server, which may end before their last callback.
struct Shared {
  WebServerOptions options;
  WebGuard guard;
  WebHandler* handler;  // null: the server has ended
  WebServerCounters counters;
  std::size_t connections = 0;
  std::set<class Client*> clients{};
};

class Client final : public WebPeer, public std::enable_shared_from_this<Client> {
 public:
  Client(std::shared_ptr<Shared> shared, tcp::socket socket, std::string protocol, std::string target)
      : shared_(std::move(shared)),
        stream_(std::move(socket)),
        stuck_(stream_.get_executor()),
        protocol_(std::move(protocol)),
        target_(std::move(target)) {
    Failure failed;
    const auto from = stream_.next_layer().remote_endpoint(failed);
    if (!failed) address_ = fmt::format("{}:{}", from.address().to_string(), from.port());
    ++shared_->connections;
  }
  ~Client() override { --shared_->connections; }

  void begin(const Request& request) {
    // Also how long a connection that has been ended may take to go.
    auto patience = beast::websocket::stream_base::timeout::suggested(beast::role_type::server);
    patience.handshake_timeout = shared_->options.request_within;
    stream_.set_option(patience);
    stream_.set_option(
        beast::websocket::stream_base::decorator([this](beast::websocket::response_type& answer) {
          answer.set(http::field::sec_websocket_protocol, protocol_);
        }));
    stream_.read_message_max(shared_->options.most_bytes_in);
    stream_.async_accept(request, [self = shared_from_this()](Failure failed) {
      if (failed || self->shared_->handler == nullptr) return;
      self->shared_->clients.insert(self.get());
      self->joined_ = true;
      self->shared_->handler->joined(*self);
      self->read();
    });
  }

  const std::string& protocol() const override { return protocol_; }
  std::string address() const override { return address_; }
  const std::string& target() const override { return target_; }
  std::uint64_t dropped() const override { return dropped_; }
  std::size_t bytes_waiting() const override { return waiting_; }

  void send(Bytes text) override { push({std::move(text), false, false}); }
  bool offer(Bytes message, bool binary) override {
    const auto before = dropped_;
    push({std::move(message), binary, true});
    return dropped_ == before;
  }

  void close(Text why) override {
    if (closing_) return;
    closing_ = true;
    reason_ = beast::websocket::close_reason(beast::websocket::close_code::policy_error,
                                             std::string(why.substr(0, 120)));
    if (!writing_) say_goodbye();
  }

  void end() {
    Failure ignored;
    stream_.next_layer().close(ignored);
    stuck_.cancel();
  }

 private:
  struct Waiting {
    Bytes bytes;
    bool binary, may_be_lost;
  };

  void push(Waiting message) {
    if (closing_ || gone_) return;
    waiting_ += message.bytes->size();
    queue_.push_back(std::move(message));
    // The first one is with the socket while writing.
    auto next = queue_.begin() + (writing_ ? 1 : 0);
    while (waiting_ > shared_->options.most_bytes_waiting && next != queue_.end()) {
      if (!next->may_be_lost) {
        ++next;
        continue;
      }
      waiting_ -= next->bytes->size();
      next = queue_.erase(next);
      ++dropped_, ++shared_->counters.dropped;
    }
    if (waiting_ > 2 * shared_->options.most_bytes_waiting) return cut_off();
    if (!writing_) write();
  }

  void write() {
    if (queue_.empty()) return closing_ ? say_goodbye() : void();
    writing_ = true;
    stuck_.expires_after(shared_->options.unread_within);
    stuck_.async_wait([self = weak_from_this()](Failure failed) {
      if (const auto client = self.lock(); client && !failed && client->writing_) client->cut_off();
    });
    stream_.binary(queue_.front().binary);
    const auto& bytes = *queue_.front().bytes;
    stream_.async_write(boost::asio::const_buffer(bytes.data(), bytes.size()),
                        [self = shared_from_this()](Failure failed, std::size_t) {
                          self->writing_ = false;
                          self->stuck_.cancel();
                          if (failed) return self->leave();
                          self->waiting_ -= self->queue_.front().bytes->size();
                          self->queue_.pop_front();
                          self->write();
                        });
  }

  void read() {
    stream_.async_read(buffer_, [self = shared_from_this()](Failure failed, std::size_t) {
      if (failed) {
        if (failed == beast::websocket::error::message_too_big) ++self->shared_->counters.refused;
        return self->leave();
      }
      if (self->shared_->handler != nullptr && !self->closing_) {
        const auto bytes = self->buffer_.data();
        self->shared_->handler->heard(*self, Text(static_cast<const char*>(bytes.data()), bytes.size()),
                                      self->stream_.got_binary());
      }
      self->buffer_.consume(self->buffer_.size());
      self->read();
    });
  }

  void say_goodbye() {
    if (gone_) return;
    stream_.async_close(reason_, [self = shared_from_this()](Failure) { self->leave(); });
  }

  void cut_off() {
    if (closing_) return;
    closing_ = true;
    ++shared_->counters.cut_off;
    // Not at once: the handler may be on its way through its clients.
    boost::asio::post(stream_.get_executor(), [self = shared_from_this()] { self->leave(); });
  }

  void leave() {
    if (gone_) return;
    gone_ = true;
    end();
    shared_->clients.erase(this);
    if (joined_ && shared_->handler != nullptr) shared_->handler->left(*this);
  }

  std::shared_ptr<Shared> shared_;
  beast::websocket::stream<tcp::socket> stream_;
  boost::asio::steady_timer stuck_;
  beast::flat_buffer buffer_;
  std::string protocol_, target_, address_ = "?";
  std::deque<Waiting> queue_;
  std::size_t waiting_ = 0;
  std::uint64_t dropped_ = 0;
  bool writing_ = false, closing_ = false, joined_ = false, gone_ = false;
  beast::websocket::close_reason reason_;
};

// One request of a connection after the other, until it becomes a WebSocket connection.
class Conversation final : public std::enable_shared_from_this<Conversation> {
 public:
  Conversation(std::shared_ptr<Shared> shared, tcp::socket socket)
      : shared_(std::move(shared)), stream_(std::move(socket)) {
    ++shared_->connections;
  }
  ~Conversation() { --shared_->connections; }

  void read() {
    parser_.emplace();
    parser_->header_limit(8 * 1024);
    parser_->body_limit(1024);
    stream_.expires_after(shared_->options.request_within);
    http::async_read(stream_, buffer_, *parser_, [self = shared_from_this()](Failure failed, std::size_t) {
      if (self->shared_->handler == nullptr) return;
      if (failed) {
        if (failed != http::error::end_of_stream) ++self->shared_->counters.refused;
        return;
      }
      ++self->shared_->counters.requests;
      self->answer(self->parser_->release());
    });
  }

 private:
  void answer(Request request) {
    const Text host = view(request[http::field::host]);
    if (!shared_->guard.admits_host(host))
      return refuse(request, http::status::misdirected_request,
                    "this server is not called that; use its own address\n");
    if (beast::websocket::is_upgrade(request)) return upgrade(request, host);
    if (request.method() != http::verb::get && request.method() != http::verb::head)
      return refuse(request, http::status::method_not_allowed, "only GET is expected\n");
    Text path = view(request.target());
    path = path.substr(0, path.find_first_of("?#"));
    const auto file = shared_->handler->file(path);
    if (!file) return say(request, http::status::not_found, "text/plain", "there is no such file\n");
    say(request, http::status::ok, file->type, file->content);
  }

  void upgrade(const Request& request, Text host) {
    if (!shared_->guard.admits_origin(view(request[http::field::origin]), host))
      return refuse(request, http::status::forbidden, "a page of another origin; it is not admitted\n");
    const auto protocol = agreed(request);
    if (!protocol)
      return refuse(request, http::status::bad_request, "no subprotocol that is spoken here is asked for\n");
    if (shared_->clients.size() >= shared_->options.most_clients)
      return refuse(request, http::status::service_unavailable,
                    "there are as many clients as there may be; close one\n");
    stream_.expires_never();
    const auto client = std::make_shared<Client>(shared_, stream_.release_socket(), *protocol,
                                                 std::string(view(request.target())));
    client->begin(request);
  }

  // The first that the client wants and the handler speaks.
  std::optional<std::string> agreed(const Request& request) const {
    const auto& spoken = shared_->options.protocols;
    for (const auto& wanted : http::token_list(request[http::field::sec_websocket_protocol]))
      if (std::find(spoken.begin(), spoken.end(), std::string(wanted)) != spoken.end())
        return std::string(wanted);
    return std::nullopt;
  }

  void refuse(const Request& request, http::status status, Text why) {
    ++shared_->counters.refused;
    say(request, status, "text/plain", why);
  }

  void say(const Request& request, http::status status, Text type, Text content) {
    answer_ = {};
    answer_.version(11);
    answer_.result(status);
    answer_.set(http::field::content_type, beast::string_view(type.data(), type.size()));
    answer_.set(http::field::cache_control, "no-store");
    answer_.set("Content-Security-Policy",
                "default-src 'self'; img-src 'self' blob: data:; frame-ancestors 'none'; "
                "base-uri 'none'; form-action 'none'");
    answer_.set("X-Content-Type-Options", "nosniff");
    answer_.set("X-Frame-Options", "DENY");
    answer_.set("Referrer-Policy", "no-referrer");
    answer_.set("Cross-Origin-Resource-Policy", "same-origin");
    answer_.keep_alive(request.keep_alive() && status == http::status::ok);
    answer_.body() = {content.data(), content.size()};
    answer_.prepare_payload();
    if (request.method() == http::verb::head) answer_.body() = {};
    stream_.expires_after(shared_->options.unread_within);
    http::async_write(stream_, answer_, [self = shared_from_this()](Failure failed, std::size_t) {
      if (failed) return;
      if (self->answer_.keep_alive()) return self->read();
      Failure ignored;
      self->stream_.socket().shutdown(tcp::socket::shutdown_send, ignored);
    });
  }

  std::shared_ptr<Shared> shared_;
  beast::tcp_stream stream_;
  beast::flat_buffer buffer_{16 * 1024};
  std::optional<http::request_parser<http::string_body>> parser_;
  http::response<http::span_body<const char>> answer_;
};

class BeastServer final : public WebServer {
 public:
  BeastServer(const WebServerOptions& options, WebHandler& handler)
      : shared_(new Shared{options, {options.address, options.hosts, options.origins}, &handler, {}}),
        acceptor_(context_) {}
  ~BeastServer() override {
    shared_->handler = nullptr;
    Failure ignored;
    acceptor_.close(ignored);
    for (auto* client : std::set(shared_->clients)) client->end();
    context_.restart();
    context_.poll();
  }

  Expected<void> listen() {
    Failure failed;
    const auto address = boost::asio::ip::make_address(shared_->options.address, failed);
    if (failed)
      return wrong_use("{}: a number is expected, as 127.0.0.1 or ::1", one_line(shared_->options.address));
    const tcp::endpoint place(address, shared_->options.port);
    const auto step = [&](Failure f) -> bool { return (failed = f), !f; };
    Failure f;
    if (!(acceptor_.open(place.protocol(), f), step(f)) ||
        !(acceptor_.set_option(tcp::acceptor::reuse_address(true), f), step(f)) ||
        !(acceptor_.bind(place, f), step(f)) || !(acceptor_.listen(64, f), step(f)))
      return refused("{} port {} cannot be had ({}); check what listens there, or name another",
                     shared_->options.address, shared_->options.port, one_line(failed.message()));
    accept();
    return {};
  }

  std::uint16_t port() const override {
    Failure failed;
    return acceptor_.local_endpoint(failed).port();
  }
  void serve_for(std::chrono::nanoseconds time) override {
    context_.restart();
    context_.run_for(time);
  }
  std::size_t clients() const override { return shared_->clients.size(); }
  WebServerCounters counters() const override { return shared_->counters; }

 private:
  void accept() {
    acceptor_.async_accept([this](Failure failed, tcp::socket socket) {
      if (!acceptor_.is_open()) return;
      if (!failed) {
        if (shared_->connections < shared_->options.most_connections) {
          Failure ignored;
          socket.set_option(tcp::no_delay(true), ignored);
          std::make_shared<Conversation>(shared_, std::move(socket))->read();
        } else {
          ++shared_->counters.refused;
        }
        return accept();
      }
      // No descriptors, say: not at once again.
      retry_.expires_after(std::chrono::milliseconds(100));
      retry_.async_wait([this](Failure ended) {
        if (!ended) accept();
      });
    });
  }

  std::shared_ptr<Shared> shared_;
  boost::asio::io_context context_{1};
  tcp::acceptor acceptor_;
  boost::asio::steady_timer retry_{context_};
};

}  // namespace

Expected<std::unique_ptr<WebServer>> WebServer::open(const WebServerOptions& options, WebHandler& handler) {
  auto server = std::make_unique<BeastServer>(options, handler);
  if (auto done = server->listen(); !done) return tl::unexpected(done.error());
  return server;
}

}  // namespace palpate::web
