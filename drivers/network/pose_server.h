// A server of live poses over TCP, in whatever protocol: every client that connects gets each pose.
//
// A thread of its own serves the clients; publish() only hands over and never waits for one. Each client has
// a queue of its own; one that takes too little loses the oldest messages, counted, and one that takes nothing
// for long is disconnected, as is one that speaks another protocol. Create it from an ordinary thread: its thread
// inherits the scheduling class.
#pragma once

#include <chrono>
#include <functional>
#include <list>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include "drivers/network/address.h"
#include "drivers/network/send_queue.h"
#include "drivers/network/tool_sample.h"
#include "palpate/core/file_descriptor.h"

namespace palpate::drivers::network {

using Stamp = std::optional<Instant<TrackerClock>>;

// A pose on its way to the clients.
struct PublishedPose {
  std::string tool;
  Stamp stamp;
  RigidPose pose;
  SendQueue::Bytes bytes;  // as PoseProtocol::encode() made them
  std::int64_t at_ns = 0;  // when it was handed over, on this machine's monotonic clock
};

// What a protocol does for one client; of the server's thread alone.
class ServedClient {
 public:
  using Push = std::function<void(SendQueue::Bytes)>;  // into the client's queue
  virtual ~ServedClient() = default;
  virtual void begin(const Push& push) = 0;
  virtual void pose(const PublishedPose& pose, const Push& push) = 0;
  // All poses that had been handed over have gone through pose().
  virtual void handed_over(const Push& push) { static_cast<void>(push); }
  // What the client says. False: it speaks another protocol.
  virtual bool take(std::string_view bytes, const Push& push) = 0;
  // Something is there for it that it has yet to ask for.
  virtual bool has_more() const { return false; }
};

class PoseProtocol {
 public:
  virtual ~PoseProtocol() = default;
  // Any thread. Refused: a pose that the protocol has no place for.
  virtual Expected<std::string> encode(const std::string& tool, Stamp stamp, const RigidPose& pose) = 0;
  // The server's thread, as what follows.
  virtual std::unique_ptr<ServedClient> meet() = 0;
  // A second socket, on which clients may ask to be connected to; -1: none. asked() gives a socket that is being connected.
  virtual int asking_fd() const { return -1; }
  virtual FileDescriptor asked() { return FileDescriptor(); }
};

struct PoseServerOptions {
  std::size_t most_clients = 16;    // further ones are turned away; sane: 1 to 256
  std::size_t most_waiting = 1024;  // messages a client, and on their way to the thread; sane: 16 to 100 000
  // A client that takes nothing for so long, while something waits for it, is disconnected, for the places
  // are few; 0 = never.
  Duration stalled_after = std::chrono::seconds(2);
};

struct PoseServerState {
  std::size_t clients = 0;        // now
  std::uint64_t accepted = 0;     // clients so far
  std::uint64_t turned_away = 0;  // clients beyond most_clients
  std::uint64_t thrown_out = 0;   // clients that speak another protocol
  std::uint64_t stalled = 0;      // clients disconnected since they took nothing
  std::uint64_t published = 0;    // poses handed to publish()
  std::uint64_t sent = 0;         // messages to clients, whole
  std::uint64_t dropped = 0;      // messages a client did not take in time
};

class PoseServer {
 public:
  // Makes the protocol's part once it is known where is listened.
  using MakeProtocol = std::function<Expected<std::unique_ptr<PoseProtocol>>(const Address&)>;

  // Refused where somebody listens there already.
  static Expected<std::unique_ptr<PoseServer>> listen(const Address& address, const MakeProtocol& make,
                                                      const PoseServerOptions& options = {});
  virtual ~PoseServer() = default;  // closes all connections

  // Any thread, but not a real-time one: it allocates. Refused: what encode() refuses.
  virtual Expected<void> publish(const std::string& tool, Stamp stamp, const RigidPose& pose) = 0;
  virtual const Address& address() const = 0;  // with the port that is served
  virtual PoseServerState state() const = 0;
  // Waits until everything published has left for its clients; false where that takes longer than so.
  virtual bool drain(Duration at_most) = 0;
};

}  // namespace palpate::drivers::network
