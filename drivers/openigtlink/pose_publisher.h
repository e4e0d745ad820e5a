// An OpenIGTLink server of live poses: every client that connects gets each pose as a TRANSFORM (header
// version 1), which 3D Slicer shows as a transform of that name.
//
// A thread of its own serves the clients; publish() only hands over and never waits for one. Each client has
// a queue of its own; one that takes too little loses the oldest poses, counted, and one that takes nothing
// for long is disconnected. A client that asks for it (STT_TDATA) gets the newest poses of all tools as TDATA
// instead, at the interval it names, until it has enough (STP_TDATA). What else clients send is read and
// ignored; one that sends something else than OpenIGTLink is disconnected. publish() takes metres and writes
// millimetres. Create it from an ordinary thread: its thread inherits the scheduling class.
#pragma once

#include <chrono>
#include <memory>

#include "drivers/openigtlink/address.h"
#include "drivers/openigtlink/codec.h"

namespace palpate::drivers::openigtlink {

struct PublisherOptions {
  std::size_t most_clients = 16;    // further ones are turned away; sane: 1 to 256
  std::size_t most_waiting = 1024;  // messages a client, and on their way to the thread; 106 bytes each;
                                    // sane: 16 to 100 000
  bool tracking_data = false;       // answers STT_TDATA: for live poses, of which only the newest matters
  // A client that takes nothing for so long, while something waits for it, is disconnected, for the places
  // are few; 0 = never.
  Duration stalled_after = std::chrono::seconds(2);
};

struct PublisherState {
  std::size_t clients = 0;        // now
  std::uint64_t accepted = 0;     // clients so far
  std::uint64_t turned_away = 0;  // clients beyond most_clients
  std::uint64_t thrown_out = 0;   // clients that sent something else than OpenIGTLink
  std::uint64_t stalled = 0;      // clients disconnected since they took nothing
  std::uint64_t published = 0;    // poses handed to publish()
  std::uint64_t sent = 0;         // messages to clients, whole
  std::uint64_t dropped = 0;      // messages a client did not take in time
};

class PosePublisher {
 public:
  // Refused where somebody listens there already.
  static Expected<std::unique_ptr<PosePublisher>> listen(const Address& address,
                                                         const PublisherOptions& options = {});
  virtual ~PosePublisher() = default;  // closes all connections

  // Any thread, but not a real-time one: it allocates. Refused: what encode() refuses.
  virtual Expected<void> publish(const std::string& tool, std::optional<Instant<TrackerClock>> stamp,
                                 const RigidPose& pose) = 0;
  virtual const Address& address() const = 0;  // with the port that is served
  virtual PublisherState state() const = 0;
  // Waits until everything published has left for its clients; false where that takes longer than so.
  virtual bool drain(Duration at_most) = 0;
};

}  // namespace palpate::drivers::openigtlink
