// ZeroMQ sockets, set up as every socket of ours is, and the context they live in. Private to the engine.
#pragma once

#include <zmq.h>

#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "palpate/core/expected.h"
#include "palpate/core/file_descriptor.h"

namespace palpate::transport::zmq {

// Messages waiting per peer and direction, but for what a ROUTER receives. A peer this far behind has more
// than a second to catch up on.
inline constexpr int kQueueLength = 64;
// Of a flood, in one turn of the thread that reads a ROUTER.
inline constexpr int kMostPassedOver = 4096;
inline constexpr int kReconnectMs = 50;
inline constexpr int kHeartbeatMs = 200;
inline constexpr int kHeartbeatTimeoutMs = 400;
inline constexpr int kHandshakeMs = 1000;
// Waiting to be accepted: a flood of strangers must not make others wait for the system's second attempt.
inline constexpr int kBacklog = 512;
inline constexpr int kConnectMs = 300;  // then another attempt: the system's own wait grows to many seconds

// One received frame, where it lies.
class Frame {
 public:
  Frame() { zmq_msg_init(&message_); }
  ~Frame() { zmq_msg_close(&message_); }
  Frame(Frame&& other) noexcept : Frame() { zmq_msg_move(&message_, &other.message_); }
  Frame& operator=(Frame&& other) = delete;
  zmq_msg_t* get() { return &message_; }
  std::string_view bytes() const {
    auto* message = const_cast<zmq_msg_t*>(&message_);  // only read, says ZeroMQ's manual
    return {static_cast<const char*>(zmq_msg_data(message)), zmq_msg_size(message)};
  }

 private:
  zmq_msg_t message_;
};

// Why ZeroMQ refused: its own numbers in its own words, the system's as everywhere.
std::string reason_of(int error);

// ZeroMQ's threads; ends with the last socket that lives in it.
using Context = std::shared_ptr<void>;
Expected<Context> make_context();

// Of a received message: the key of who sent it, empty where the connection is not encrypted, and the
// connection's descriptor in this process, which may be another connection's by now.
struct Sender {
  std::string user;
  int descriptor = -1;
};

class Socket {
 public:
  // `type` is one of ZeroMQ's; in a context of its own where none is given. A peer that sends a frame above
  // `max_frame_bytes` loses its connection; by default shapes fit into a DEALER, and any message elsewhere.
  static Expected<Socket> make(int type, Context context = nullptr,
                               std::optional<std::size_t> max_frame_bytes = {});
  // Takes all that comes, whether anybody reads it or not. Before it is bound or connected.
  bool receive_without_bound();
  Socket(Socket&& other) noexcept;
  Socket& operator=(Socket&& other) = delete;
  ~Socket();

  // Listens there; a unix socket's file is its user's alone from its first moment.
  Expected<void> bind(const std::string& address);

  void* get() const { return socket_; }
  int fd() const;                // readable when events() may have changed
  bool readable() const;         // a message can be received now
  std::string endpoint() const;  // bound to

  enum class Received { nothing, message, rejected };
  // The next message of `frames` frames, without waiting; the last frame goes to `body`, the one before to
  // `peer`. The frames of a shape may follow where `rest` is given, and go there. rejected: a message with
  // another number of frames.
  Received receive(int frames, std::string* peer, std::string& body, Sender* sender = nullptr,
                   std::vector<Frame>* rest = nullptr);
  // One frame, without waiting. False when it cannot leave now.
  bool send(std::string_view bytes, bool more = false);
  // The same without a copy: `owner` is let go of when the bytes have left.
  bool send(std::string_view bytes, std::shared_ptr<const void> owner, bool more);

 private:
  Socket(Context context, void* socket) : context_(std::move(context)), socket_(socket) {}
  Context context_;
  void* socket_;
};

// A random number that is not 0, other at each call and in each process. Names, not secrets.
std::uint64_t new_name(std::string_view purpose);

// The eventfd that wakes a waiting thread, as a rule to end it.
class Stop {
 public:
  Stop();
  void set();
  void clear();
  int fd() const { return fd_.get(); }

 private:
  FileDescriptor fd_;
};

}  // namespace palpate::transport::zmq
