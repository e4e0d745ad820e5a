#include "palpate/transport/internal/zmq_publisher.h"

#include <poll.h>
#include <zmq.h>

#include <algorithm>
#include <cerrno>

#include "palpate/time/real_time.h"
#include "palpate/transport/messages.h"

namespace palpate::transport::zmq {
namespace {

constexpr Duration kLookAtLeastEvery = std::chrono::milliseconds(100);
// Observers of many different rates together do not wake the thread more often than this.
constexpr Duration kSleepAtLeast = std::chrono::microseconds(250);

}  // namespace

Expected<std::unique_ptr<Publisher>> Publisher::make(const Context& context, const Endpoint& endpoint,
                                                     ConnectionGuard& guard,
                                                     const Authenticator* authenticator,
                                                     const Clock<PhysicsClock>& clock, StateSource source) {
  std::optional<SocketClaim> claim;
  if (endpoint.local()) {
    auto taken = SocketClaim::take(endpoint.socket);
    if (!taken) return tl::unexpected(taken.error());
    claim = std::move(*taken);
  }
  auto socket = Socket::make(ZMQ_ROUTER, context, kMaxRequestBytes);
  if (!socket) return tl::unexpected(socket.error());
  if (authenticator != nullptr)
    if (auto guarded = authenticator->guard(*socket); !guarded) return tl::unexpected(guarded.error());
  if (auto watched = guard.watch(*socket, context); !watched) return tl::unexpected(watched.error());
  if (auto bound = socket->bind(endpoint.address); !bound) {
    guard.leave(*socket);
    return tl::unexpected(bound.error());
  }
  return std::make_unique<Publisher>(std::move(*socket), guard, authenticator, std::move(claim), clock,
                                     std::move(source));
}

Publisher::Publisher(Socket socket, ConnectionGuard& guard, const Authenticator* authenticator,
                     std::optional<SocketClaim> claim, const Clock<PhysicsClock>& clock, StateSource source)
    : claim_(std::move(claim)),
      guard_(guard),
      authenticator_(authenticator),
      socket_(std::move(socket)),
      endpoint_(socket_.endpoint()),
      clock_(clock),
      source_(std::move(source)),
      thread_([this] { run(); }) {}

Publisher::~Publisher() {
  stop_.set();
  thread_.join();
  guard_.leave(socket_);
}

void Publisher::check_keys() {
  check_keys_ = true;
  wake_.set();
}

void Publisher::run() {
  name_and_pin_thread("palpate-pub", -1);
  while (true) {
    if (check_keys_.exchange(false) && authenticator_ != nullptr)
      subscriptions_.keep_only(
          [this](const std::string& key) { return authenticator_->role_of(key).has_value(); });
    const Instant<PhysicsClock> now = clock_.now();
    subscriptions_.drop_lapsed(now);
    send_what_is_due(now);
    // After the sending, which may have swallowed the signal that a message has come.
    const bool more = take_messages();
    Duration wait = kLookAtLeastEvery;
    if (const auto due = subscriptions_.next_due()) wait = std::min(wait, *due - clock_.now());
    wait = more ? Duration(0) : std::max(wait, kSleepAtLeast);
    const timespec time{wait.count() / 1'000'000'000, wait.count() % 1'000'000'000};
    pollfd items[] = {{socket_.fd(), POLLIN, 0}, {stop_.fd(), POLLIN, 0}, {wake_.fd(), POLLIN, 0}};
    ::ppoll(items, 3, &time, nullptr);
    if ((items[1].revents & POLLIN) != 0) return;
    if ((items[2].revents & POLLIN) != 0) wake_.clear();
  }
}

// True where more may have come: bounded, so that a flood does not hold up the others' states.
bool Publisher::take_messages() {
  for (int looked_at = 0, passed_over = 0; looked_at < kQueueLength && passed_over < kMostPassedOver;) {
    const auto received = socket_.receive(2, &peer_, body_, &sender_);
    if (received == Socket::Received::nothing) return false;
    const auto share = limit_.count(peer_, body_.size(), clock_.now());
    const bool admitted = share == RateLimit::Share::within;
    if (share == RateLimit::Share::flood) guard_.cut_off(sender_);
    ++(admitted ? looked_at : passed_over);
    // A key that is admitted no more gets no answer either.
    const auto role =
        authenticator_ == nullptr ? std::optional(Role::operator_) : authenticator_->role_of(sender_.user);
    const bool heard = admitted && received == Socket::Received::message && role &&
                       guard_.heard(sender_, role == Role::operator_);
    const Expected<void> taken = heard ? take(body_) : Expected<void>();
    if (heard && taken) continue;
    rejected_.fetch_add(1, std::memory_order_relaxed);
    if (!taken && socket_.send(peer_, true))
      socket_.send(encode(ServerMessage(Refusal{taken.error().message})));
  }
  return true;
}

Expected<void> Publisher::take(std::string_view message) {
  const auto decoded = decode_client_message(message);
  if (!decoded) return tl::unexpected(decoded.error());
  const auto* subscribe = std::get_if<Subscribe>(&*decoded);
  if (subscribe == nullptr)
    return refused("nothing but subscriptions is taken here; ask the server's own address");
  return subscriptions_.renew(peer_, sender_.user, subscribe->rate_hz, clock_.now());
}

void Publisher::send_what_is_due(Instant<PhysicsClock> now) {
  const Instant<PhysicsClock> time = now - kObserverDelay;
  std::optional<scene::StateAnswer> answer;  // looked up once, where anybody is to have it
  subscriptions_.for_each_due(now, [&](const std::string& peer, std::uint64_t number) {
    if (!answer) answer = source_(time);
    if (!answer->usable()) return true;
    if (socket_.send(peer, true)) {
      if (socket_.send(encode(ServerMessage(StateReply{number, time, *answer, nullptr}))))
        published_.fetch_add(1, std::memory_order_relaxed);
      return true;
    }
    if (zmq_errno() == EHOSTUNREACH) return false;
    unsent_.fetch_add(1, std::memory_order_relaxed);
    return true;
  });
}

}  // namespace palpate::transport::zmq
