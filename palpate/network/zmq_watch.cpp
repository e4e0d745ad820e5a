#include <zmq.h>

#include <cerrno>

#include "palpate/network/state_watch.h"
#include "palpate/network/zmq_gate.h"
#include "palpate/network/zmq_publisher.h"

namespace palpate {
namespace {

class ZmqWatch : public StateWatch {
 public:
  explicit ZmqWatch(zmq::Socket socket) : socket_(std::move(socket)) {}

  std::optional<StateReply> take() override {
    std::optional<StateReply> newest;
    while (socket_.readable()) {
      const auto received = socket_.receive(2, nullptr, body_);
      if (received == zmq::Socket::Received::nothing) break;
      auto message = received == zmq::Socket::Received::message
                         ? decode_server_message(body_)
                         : Expected<ServerMessage>(refused("another number of frames"));
      auto* reply = message ? std::get_if<StateReply>(&*message) : nullptr;
      if (reply == nullptr) {
        ++counters_.rejected;
        continue;
      }
      if (newest) ++counters_.skipped;
      ++counters_.taken;
      // Counted anew from 1 where the server, or the rate there, begins anew.
      if (last_ > 0 && reply->number > last_ + 1) counters_.missed += reply->number - last_ - 1;
      last_ = reply->number;
      newest = *reply;
    }
    return newest;
  }
  Counters counters() const override { return counters_; }

 private:
  zmq::Socket socket_;
  std::string body_;
  Counters counters_;
  std::uint64_t last_ = 0;
};

}  // namespace

Expected<std::unique_ptr<StateWatch>> watch_states(const Endpoint& service, int rate_hz,
                                                   const std::optional<ClientIdentity>& identity) {
  if (rate_hz < 1 || rate_hz > zmq::kMaxRate)
    return wrong_use("states at {} Hz: a whole number from 1 to {} is expected", rate_hz, zmq::kMaxRate);
  const auto states = states_endpoint(service);
  if (!states) return tl::unexpected(states.error());
  if (states->encrypted && !identity)
    return wrong_use("{}: this machine's keys and the server's are needed to connect there", states->address);
  auto socket = zmq::Socket::make(ZMQ_SUB);
  if (!socket) return tl::unexpected(socket.error());
  if (states->encrypted)
    if (auto done = zmq::encrypt(*socket, *identity); !done) return tl::unexpected(done.error());
  const std::string topic = zmq::topic_of(rate_hz);
  if (zmq_setsockopt(socket->get(), ZMQ_SUBSCRIBE, topic.data(), topic.size()) != 0 ||
      zmq_connect(socket->get(), states->address.c_str()) != 0)
    return refused("{}: cannot connect there: {}", states->address, zmq_strerror(errno));
  return std::make_unique<ZmqWatch>(std::move(*socket));
}

}  // namespace palpate
