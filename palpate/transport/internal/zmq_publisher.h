// States for observers: each subscribes at a rate of its choice and gets the states, without asking for each.
//
// A ROUTER beside the service's, in the same context and behind the same authenticator. An observer says
// Subscribe and says it again before its lease is over (subscriptions.h); it gets a StateReply so many times
// a second, with the state of a moment ago (kObserverDelay), so that it is known and not guessed. What an
// observer does not take is lost to it and counted; nobody waits for it. Messages above kMaxRequestBytes cost
// whoever sends them the connection, before they are in memory.
//
// The address is bound once, before the thread begins, and never again: where no descriptor is left, zmq_bind
// ends the process. So nothing that an observer does may make this socket close. Private to the engine; a
// thread of its own, "palpate-pub".
#pragma once

#include <atomic>
#include <memory>
#include <thread>

#include "palpate/time/clock.h"
#include "palpate/transport/internal/rate_limit.h"
#include "palpate/transport/internal/subscriptions.h"
#include "palpate/transport/internal/zmq_authenticator.h"
#include "palpate/transport/internal/zmq_connection_guard.h"
#include "palpate/transport/local_endpoint.h"
#include "palpate/transport/state_service.h"

namespace palpate::transport::zmq {

inline constexpr Duration kObserverDelay = std::chrono::milliseconds(2);
// A Subscribe has 7 bytes; CurveZMQ's handshake, to which the bound applies as well, needs some 260.
inline constexpr std::size_t kMaxRequestBytes = 512;
inline constexpr int kMessages_hz = 200;  // of one connection; an observer sends one a second

class Publisher {
 public:
  // Refused where the address is taken. `guard` and `authenticator`, where there is one, must outlive the
  // publisher.
  static Expected<std::unique_ptr<Publisher>> make(const Context& context, const Endpoint& endpoint,
                                                   ConnectionGuard& guard, const Authenticator* authenticator,
                                                   const Clock<PhysicsClock>& clock, StateSource source);
  Publisher(Socket socket, ConnectionGuard& guard, const Authenticator* authenticator,
            std::optional<SocketClaim> claim, const Clock<PhysicsClock>& clock, StateSource source);
  ~Publisher();
  Publisher(const Publisher&) = delete;
  Publisher& operator=(const Publisher&) = delete;

  // Somebody has lost the right to be here: whose key is no longer admitted gets no more states. Any thread.
  void check_keys();
  const std::string& endpoint() const { return endpoint_; }
  // Any thread: states sent; states that an observer did not take; messages refused.
  std::uint64_t published() const { return published_.load(std::memory_order_relaxed); }
  std::uint64_t unsent() const { return unsent_.load(std::memory_order_relaxed); }
  std::uint64_t rejected() const { return rejected_.load(std::memory_order_relaxed); }

 private:
  void run();
  bool take_messages();
  Expected<void> take(std::string_view message);
  void send_what_is_due(Instant<PhysicsClock> now);

  std::optional<SocketClaim> claim_;
  ConnectionGuard& guard_;
  const Authenticator* authenticator_;
  Socket socket_;
  std::string endpoint_;
  const Clock<PhysicsClock>& clock_;
  StateSource source_;
  Subscriptions subscriptions_;
  RateLimit limit_{kMessages_hz, 20 * kMessages_hz};
  std::string peer_, body_;  // of the message being looked at
  Sender sender_;            // of the same
  std::atomic<std::uint64_t> published_{0}, unsent_{0}, rejected_{0};
  std::atomic<bool> check_keys_{false};
  Stop stop_, wake_;
  std::thread thread_;
};

}  // namespace palpate::transport::zmq
