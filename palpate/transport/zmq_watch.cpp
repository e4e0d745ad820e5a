#include <zmq.h>

#include <cerrno>

#include "palpate/core/system_error.h"
#include "palpate/time/clock.h"
#include "palpate/transport/internal/zmq_authenticator.h"
#include "palpate/transport/state_watch.h"

namespace palpate::transport {
namespace {

constexpr Duration kRenewEvery = std::chrono::seconds(1);
// ZeroMQ connects again by itself, but not where it was turned away; a key may be admitted later.
constexpr Duration kGivenUpAfter = std::chrono::seconds(3);

class ZmqWatch : public StateWatch {
 public:
  ZmqWatch(zmq::Socket socket, std::string address, int rate_hz)
      : socket_(std::move(socket)),
        address_(std::move(address)),
        subscribe_(encode(ClientMessage(Subscribe{rate_hz}))) {}

  std::optional<StateReply> take() override {
    const Instant<GraphicsClock> now = clock_.now();
    std::optional<StateReply> newest;
    // Bounded, should more come all the while.
    for (int taken = 0; taken < zmq::kMostPassedOver && socket_.readable(); ++taken) {
      const auto received = socket_.receive(1, nullptr, body_);
      if (received == zmq::Socket::Received::nothing) break;
      heard_ = now;
      auto message = received == zmq::Socket::Received::message
                         ? decode_server_message(body_)
                         : Expected<ServerMessage>(refused("another number of frames"));
      if (const auto* refusal = message ? std::get_if<Refusal>(&*message) : nullptr)
        refusal_ = refusal->reason;
      else if (const auto* reply = message ? std::get_if<StateReply>(&*message) : nullptr)
        newest = counted(*reply, newest.has_value());
      else
        ++counters_.rejected;
    }
    if (now - heard_ > kGivenUpAfter) connect_anew(now);
    if ((!renewed_ || now - *renewed_ >= kRenewEvery) && socket_.send(subscribe_)) renewed_ = now;
    return newest;
  }
  std::optional<std::string> refusal() const override { return refusal_; }
  Counters counters() const override { return counters_; }

 private:
  StateReply counted(const StateReply& reply, bool skips) {
    refusal_.reset();
    if (skips) ++counters_.skipped;
    ++counters_.taken;
    // Counted anew from 1 where the server, or the subscription there, begins anew.
    if (last_ > 0 && reply.number > last_ + 1) counters_.missed += reply.number - last_ - 1;
    last_ = reply.number;
    return reply;
  }
  void connect_anew(Instant<GraphicsClock> now) {
    zmq_disconnect(socket_.get(), address_.c_str());  // nothing there any more, mostly
    zmq_connect(socket_.get(), address_.c_str());
    heard_ = now;
    renewed_.reset();
  }

  zmq::Socket socket_;
  std::string address_, subscribe_, body_;
  MonotonicClock<GraphicsClock> clock_;
  Instant<GraphicsClock> heard_ = clock_.now();
  std::optional<Instant<GraphicsClock>> renewed_;
  std::optional<std::string> refusal_;
  Counters counters_;
  std::uint64_t last_ = 0;
};

}  // namespace

Expected<std::unique_ptr<StateWatch>> watch_states(const Endpoint& service, int rate_hz,
                                                   const std::optional<ClientIdentity>& identity) {
  if (rate_hz < 1 || rate_hz > kMaxSubscriptionRate_hz)
    return wrong_use("states at {} Hz: a whole number from 1 to {} is expected", rate_hz,
                     kMaxSubscriptionRate_hz);
  const auto states = states_endpoint(service);
  if (!states) return tl::unexpected(states.error());
  if (states->encrypted && !identity)
    return wrong_use("{}: this machine's keys and the server's are needed to connect there", states->address);
  auto socket = zmq::Socket::make(ZMQ_DEALER, nullptr, kMaxMessageBytes);
  if (!socket) return tl::unexpected(socket.error());
  if (states->encrypted)
    if (auto done = zmq::encrypt(*socket, *identity); !done) return tl::unexpected(done.error());
  // Bounded by the subscription, which lapses where nobody takes states.
  if (!socket->receive_without_bound() || zmq_connect(socket->get(), states->address.c_str()) != 0)
    return refused("{}: cannot connect there: {}", states->address, reason_of(errno));
  return std::make_unique<ZmqWatch>(std::move(*socket), states->address, rate_hz);
}

}  // namespace palpate::transport
