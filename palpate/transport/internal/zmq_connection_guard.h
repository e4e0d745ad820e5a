// Keeps the number of connections to the physics server bounded, so that nobody takes the descriptors, or the
// places, of the others (connections.h says who has to end).
//
// libzmq 4.3.4 accepts by itself, in a thread of its own, whoever comes. The guard is told of every connection
// that begins and ends, and shuts one down that has to end: to libzmq it is then as if its peer had gone. The
// service asks it about every message. It also gives memory back to the system that messages have left behind,
// such as those of a connection that ended in the middle of one. Private to the engine; a thread of its own,
// "palpate-guard".
#pragma once

#include <atomic>
#include <list>
#include <memory>
#include <mutex>
#include <thread>

#include "palpate/core/file_descriptor.h"
#include "palpate/time/clock.h"
#include "palpate/time/freed_memory.h"
#include "palpate/transport/internal/connections.h"
#include "palpate/transport/zmq_socket.h"

namespace palpate::transport::zmq {

// Descriptors that connections leave to the rest of the process, where there are enough.
inline constexpr std::size_t kDescriptorsLeft = 64;

inline constexpr std::chrono::milliseconds kLeaveWithin{500};

inline constexpr std::size_t kFreeMemoryKept = 16 << 20;  // more than what large messages in turn need

class ConnectionGuard {
 public:
  // `clock` must be safe from any thread and outlive the guard.
  static Expected<std::unique_ptr<ConnectionGuard>> make(const Clock<PhysicsClock>& clock);
  explicit ConnectionGuard(const Clock<PhysicsClock>& clock);
  ~ConnectionGuard();
  ConnectionGuard(const ConnectionGuard&) = delete;
  ConnectionGuard& operator=(const ConnectionGuard&) = delete;

  // Before the listener is bound, and in the same context; leave() before it is closed.
  Expected<void> watch(const Socket& listener, const Context& context);
  // Ends the listener's connections, waits for it (kLeaveWithin at most), and watches no longer. A listener must not
  // close with a peer still sending: for a moment libzmq cannot take in what comes, and a connection that ends just
  // then is the assertion of Socket::receive_without_bound.
  void leave(const Socket& listener);

  // Any thread: whether what was said over this descriptor is to be heard (Connections::heard).
  bool heard(const Sender& sender, bool by_operator);
  // Any thread: the connection that this came by ends, if it is still there.
  void cut_off(const Sender& sender);
  // Any thread: the key has all the connections it may have.
  bool full(const std::string& key);

 private:
  struct Watched {
    int number;  // of the listener, in connections_
    void* listener;
    Socket events;  // PAIR
  };
  void run();
  void take_events();
  void end_what_is_overdue();
  bool end_all_of(const void* listener);
  void end(const Connections::Ended& one);
  void give_back_memory();
  std::size_t places() const;

  const Clock<PhysicsClock>& clock_;
  Stop stop_;
  std::size_t others_;    // descriptors that are no connections
  FileDescriptor spare_;  // one of them, for a connection while it is shut down
  std::mutex mutex_;      // of the next five
  std::list<Watched> watched_;
  int listeners_ = 0;  // so far
  Connections connections_;
  std::string event_, where_;
  FreedMemory memory_{kFreeMemoryKept, resident_bytes(), freed_bytes()};  // the guard's thread alone
  Instant<PhysicsClock> memory_looked_at_;
  std::thread thread_;
};

}  // namespace palpate::transport::zmq
