// A client's connection to its physics server, and how much may come over it. An honest server answers what it
// is asked; one that sends far more than anybody asks for, or a message that never ends, would fill this
// process's memory, so its connection ends. Private to the engine; one thread.
//
// The queue in which libzmq keeps what has come has no bound of its own: one that is full ends the process (see
// Socket::receive_without_bound).
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>

#include "palpate/time/clock.h"
#include "palpate/transport/messages.h"

namespace palpate::transport::zmq {

class ServerConnection {
 public:
  // In a tenth of a second. Twenty thousand answers a second are as many as a server gives to one connection, and
  // after a pause of ours all that it had in its queue comes at once; 120 of the largest shapes a second are 12 MB.
  static constexpr std::size_t kMostMessages = 6000, kMostBytes = std::size_t{24} << 20;
  // Beside what messages may hold: frames' heads, and what comes while one looks.
  static constexpr std::uint64_t kSlackBytes = 64 << 10;
  // Shapes that nobody has looked at yet: a server has no more than so many on their way.
  static constexpr int kMostShapesWaiting = 4;

  // As the socket's events tell it; the descriptor may be another's by now.
  void began(int descriptor);
  void ended();
  bool there() const { return number_.has_value(); }
  // How many bytes a message may have from now on; what is read of one beyond twice that has no end.
  void expect(std::size_t largest) { largest_ = largest; }

  // One more message has come. False: more has come than is looked at; it is passed over.
  bool count(std::size_t bytes, Instant<GraphicsClock> now);
  // To be asked after what has come was counted, some times a second at least: whether it has to end, for a flood or
  // a message without an end. Over a unix socket nobody counts bytes that are no
  // message yet; who can listen there is this user.
  bool too_much();
  // Ends it: to libzmq it is as if the peer had gone.
  void end();

 private:
  std::optional<std::uint64_t> bytes_read() const;

  int descriptor_ = -1;
  std::optional<std::uint64_t> number_;  // the kernel's, of the socket
  std::size_t largest_ = kMaxMessageBytes;
  std::uint64_t whole_ = 0;  // bytes read when the last whole message had come, as it was last looked
  bool came_ = false;        // a message since
  std::int64_t window_ = 0;
  std::size_t messages_ = 0, bytes_ = 0;  // in this window
  bool flood_ = false;
};

}  // namespace palpate::transport::zmq
