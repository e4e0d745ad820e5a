// The poses that an OpenIGTLink server sends: TRANSFORM (the tool is the message's device name, such as
// "StylusToTracker") and TDATA (a tool for each element).
//
// A thread of its own connects, reads, and connects again within a second of the server's return; nobody who
// calls the functions below ever waits for the network. Poses wait in a queue of kMostWaiting; whoever takes
// none for long loses the oldest, counted. Frames: tool to whatever frame the server measures in; metres.
// Create it from an ordinary thread: its thread inherits the scheduling class.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "drivers/openigtlink/address.h"
#include "drivers/openigtlink/codec.h"

namespace palpate::drivers::openigtlink {

struct ToolSample {
  std::string tool;
  // The server's time of the measurement; where it states none (server_time false), the time of arrival on
  // this machine's monotonic clock.
  Instant<TrackerClock> stamp;
  bool server_time = false;
  std::int64_t arrived_ns = 0;  // on this machine's monotonic clock
  bool seen = true;             // false: the server says that the pose is not valid
  RigidPose pose;
};

// Some servers send tracking data only to a client that has asked for it (STT_TDATA).
enum class StartRequest {
  when_silent,  // asks where no pose has come half a second after connecting
  at_once,
  never,
};

struct TrackerClientOptions {
  StartRequest start = StartRequest::when_silent;
  int period_ms = 10;  // asked for: at most a message in this time; 0 = as fast as the server can
};

struct TrackerClientState {
  bool connected = false;
  std::uint64_t connections = 0;  // made so far
  std::uint64_t samples = 0;      // taken into the queue
  std::uint64_t lost = 0;         // oldest ones, dropped since nobody took them
  std::uint64_t repeats = 0;      // the same stamp and pose of a tool again: left out
  std::uint64_t too_many = 0;     // of tools beyond kMostTools: left out
  std::uint64_t bad_crc = 0;      // messages damaged on the way
  std::uint64_t refused = 0;      // messages that make no sense
  std::uint64_t skipped = 0;      // messages of kinds that are not read
  std::string trouble;            // newest: a message refused, a connection ended, an error status; or empty
};

class TrackerClient {
 public:
  static constexpr std::size_t kMostWaiting = 16384;  // samples
  static constexpr std::size_t kMostTools = 256;

  // Wrong use where the host's name is unknown: it is looked up here, once. Whether a server is there yet
  // does not matter.
  static Expected<std::unique_ptr<TrackerClient>> connect(const Address& server,
                                                          const TrackerClientOptions& options = {});
  virtual ~TrackerClient() = default;  // ends the thread

  // All samples since the last call, oldest first. Any thread.
  virtual std::vector<ToolSample> poll() = 0;
  virtual TrackerClientState state() const = 0;
};

}  // namespace palpate::drivers::openigtlink
