// The poses that a server sends, over TCP, in whatever protocol.
//
// A thread of its own connects, reads, and connects again within a second of the server's return; nobody who
// calls the functions below ever waits for the network. Poses wait in a queue of kMostWaiting; whoever takes
// none for long loses the oldest, counted. Frames: tool to whatever frame the server measures in; metres.
// Create it from an ordinary thread: its thread inherits the scheduling class.
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "drivers/network/address.h"
#include "drivers/network/tool_sample.h"

namespace palpate::drivers::network {

// What a protocol makes of one connection; of the client's thread alone. Times: this machine's monotonic clock, ns.
class Conversation {
 public:
  // What comes of a step.
  struct Turn {
    std::vector<ToolSample> heard;
    std::string out;      // bytes for the server; few: they leave at once, or not at all
    std::string trouble;  // the newest, in words; it may go on all the same
  };
  struct Counts {
    std::uint64_t damaged = 0;  // messages that the way has changed, where the protocol can tell
    std::uint64_t refused = 0;  // messages that make no sense
    std::uint64_t skipped = 0;  // messages of kinds that are not read
  };

  virtual ~Conversation() = default;
  virtual void begin(std::int64_t now_ns, Turn& turn) = 0;
  // False: the connection is over, Turn::trouble says why.
  virtual bool take(std::string_view bytes, std::int64_t now_ns, Turn& turn) = 0;
  // When it wants to be asked again although nothing has come; none: never.
  virtual std::optional<std::int64_t> due_ns() const { return std::nullopt; }
  // False as of take().
  virtual bool ask(std::int64_t now_ns, Turn& turn) {
    static_cast<void>(now_ns), static_cast<void>(turn);
    return true;
  }
  // Before the client closes the connection by itself.
  virtual void end(Turn& turn) { static_cast<void>(turn); }
  virtual Counts counts() const = 0;
};

struct PoseClientState {
  bool connected = false;
  std::uint64_t connections = 0;  // made so far
  std::uint64_t samples = 0;      // taken into the queue
  std::uint64_t lost = 0;         // oldest ones, dropped since nobody took them
  std::uint64_t repeats = 0;      // the same stamp and pose of a tool again: left out
  std::uint64_t too_many = 0;     // of tools beyond kMostTools: left out
  Conversation::Counts messages;  // of all connections
  std::string trouble;            // newest: a message refused, a connection ended, an error status; or empty
};

class PoseClient {
 public:
  static constexpr std::size_t kMostWaiting = 16384;  // samples
  static constexpr std::size_t kMostTools = 256;
  using Begin = std::function<std::unique_ptr<Conversation>()>;

  // Wrong use where the host's name is unknown: it is looked up here, once. Whether a server is there yet
  // does not matter. `begin` is called in the client's thread, for each connection.
  static Expected<std::unique_ptr<PoseClient>> connect(const Address& server, Begin begin);
  virtual ~PoseClient() = default;  // ends the thread

  // All samples since the last call, oldest first. Any thread.
  virtual std::vector<ToolSample> poll() = 0;
  virtual PoseClientState state() const = 0;
};

}  // namespace palpate::drivers::network
