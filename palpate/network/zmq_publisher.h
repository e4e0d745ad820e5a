// States for observers: each subscribes to a rate of its choice and gets the states, without asking.
//
// An XPUB socket beside the service's ROUTER, in the same context and behind the same gate. Topic "state@30;"
// is 30 states a second, any whole number from 1 to 1000; a message is two frames, the topic and a ToGraphics
// with a StateReply, the state of a moment ago (kObserverDelay), so that it is known and not guessed. An
// observer that does not take its mail loses what does not fit into its queue; nobody waits for it. ZeroMQ
// keeps every topic anybody asks for, so an observer that asks for too many is shut out. Private to the
// engine; a thread of its own, "palpate-pub".
#pragma once

#include <atomic>
#include <map>
#include <memory>
#include <thread>

#include "palpate/network/local_endpoint.h"
#include "palpate/network/state_service.h"
#include "palpate/network/zmq_gate.h"
#include "palpate/time/clock.h"

namespace palpate::zmq {

inline constexpr Duration kObserverDelay = std::chrono::milliseconds(2);
inline constexpr int kMaxRate = 1000;                      // Hz
inline constexpr std::size_t kMaxRatesAtOnce = 16;         // each costs a look-up and an encoding per state
inline constexpr std::size_t kMaxRatesEach = 4;            // that a key has asked for first
inline constexpr std::size_t kMaxTopicBytes = 128 * 1024;  // of all topics; ZeroMQ takes some 40 for each

std::string topic_of(int rate_hz);

class Publisher {
 public:
  // Refused where the address is taken. `gate`, where there is one, must outlive the publisher.
  static Expected<std::unique_ptr<Publisher>> make(const Context& context, const Endpoint& endpoint,
                                                   const Gate* gate, const Clock<PhysicsClock>& clock,
                                                   StateSource source);
  Publisher(Context context, Socket socket, const Gate* gate, std::optional<SocketClaim> claim,
            const Clock<PhysicsClock>& clock, StateSource source);
  ~Publisher();
  Publisher(const Publisher&) = delete;
  Publisher& operator=(const Publisher&) = delete;

  // Every observer has to come in through the gate again: somebody has lost the right to be here. Any thread.
  void begin_anew();
  const std::string& endpoint() const { return endpoint_; }
  std::uint64_t published() const { return published_.load(std::memory_order_relaxed); }
  // How often somebody asked for too many topics.
  std::uint64_t floods() const { return floods_.load(std::memory_order_relaxed); }

 private:
  void run();
  void take_wishes();
  void choose_rates();
  void shut_out_the_greediest();
  void publish_what_is_due(Instant<PhysicsClock> now);
  void reopen();

  std::optional<SocketClaim> claim_;
  Context context_;
  const Gate* gate_;
  std::optional<Socket> socket_;
  std::string endpoint_;
  const Clock<PhysicsClock>& clock_;
  StateSource source_;
  struct Rate {
    Instant<PhysicsClock> due;  // the next moment to publish
    std::uint64_t number = 0;   // of the last state: a gap tells an observer what it missed
  };
  std::map<int, Rate> rates_;                  // by Hz
  std::map<std::string, std::string> topics_;  // wanted now, and the key that asked first ("": not encrypted)
  std::size_t topic_bytes_ = 0;
  std::atomic<std::uint64_t> published_{0}, floods_{0};
  std::atomic<bool> anew_{false};
  Stop stop_, wake_;
  std::thread thread_;
};

}  // namespace palpate::zmq
