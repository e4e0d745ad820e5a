// A graphics server's end of the exchange: ask for the state at the image's time, go on working, take what
// has come.
//
// Nothing here waits for the network. All calls from one thread, the graphics loop; poll() once or more per
// frame. The link says hello, notices within a second when the physics server has gone, and is back by itself
// when it returns. The engine underneath is a LinkWire: ZeroMQ (zmq_engine.h) or the in-process transport
// (in_process.h).
#pragma once

#include <array>
#include <cstdint>
#include <deque>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "palpate/transport/messages.h"
#include "palpate/transport/request_tracker.h"

namespace palpate::transport {

// A message from the physics server with the moment it reached this machine; nothing inside: it failed the
// check.
struct Arrival {
  Instant<GraphicsClock> received;
  std::optional<ServerMessage> message;
  // Of the answer to a clock question that the wire asked by itself: when that left.
  std::optional<Instant<GraphicsClock>> asked;
};

// Why no connection comes about: their side does not admit our key, or takes no more connections with it, or
// the two sides' encryption does not agree, or it has sent far more than it was asked for and was cut off.
enum class LinkTrouble { not_admitted, no_place, no_agreement, flood };

// What carries a link's messages. One caller's thread; neither call waits.
class LinkWire {
 public:
  static constexpr std::uint64_t kSyncTrain = 8;
  virtual ~LinkWire() = default;
  virtual Instant<GraphicsClock> now() const = 0;
  // The moment just before the bytes left, or nothing where nobody is connected.
  // A wire may follow a clock question up by itself with the next kSyncTrain - 1 numbers, each the moment the
  // answer before it has come.
  virtual std::optional<Instant<GraphicsClock>> send(const ClientMessage& message) = 0;
  // The next message that has come, in the order of arrival.
  virtual bool take(Arrival& arrival) = 0;
  // Why no connection comes about, where the wire knows.
  virtual std::optional<LinkTrouble> trouble() const { return std::nullopt; }
};

// A reply with the moments its request left and it came: received - sent is the round trip.
struct ArrivedState {
  StateReply reply;
  Instant<GraphicsClock> sent, received;
  bool newest = false;  // false: overtaken by the reply to a later request
};

// Four time stamps of one exchange: sent, received there, answered there, received here (RFC 5905, section
// 8).
struct SyncStamps {
  Instant<GraphicsClock> t1;
  Instant<PhysicsClock> t2, t3;
  Instant<GraphicsClock> t4;
};

class StateLink {
 public:
  static constexpr Duration kHelloEvery = std::chrono::milliseconds(200);
  static constexpr Duration kGoneAfter = std::chrono::milliseconds(600);  // of a question without any answer
  static constexpr Duration kControlKept =
      std::chrono::seconds(2);  // a wish older than this is not carried out

  // `client` is a random number that names this client for its life, not 0.
  StateLink(std::unique_ptr<LinkWire> wire, std::uint64_t client, std::string name);

  // Asks for the state at `time`, with the shape of the surface that deforms or without. Numbers must grow.
  // False when the request could not go out.
  bool request(std::uint64_t number, Instant<PhysicsClock> time, bool shape = false);
  // Takes what has come and says hello when that is due.
  void poll();
  // The frame that wanted reply `number` has been drawn, with it or without.
  void frame_drawn(std::uint64_t number) { request_tracker_.drawn(number); }

  // Reply to the latest request answered so far.
  const std::optional<ArrivedState>& newest() const { return newest_; }
  // The shape for the latest time that has come so far, of description()->shape_vertices; empty while there
  // is none.
  const std::shared_ptr<const scene::Shape>& newest_shape() const { return newest_shape_; }
  // What the last poll() brought, in the order of arrival.
  std::span<const ArrivedState> arrived() const { return arrived_; }

  // Asks for the state of some moment besides the frames' own, to look back at it: not counted among their requests.
  // False when it could not go out. `number` comes back with the answer and stays below kLookBack.
  static constexpr std::uint64_t kLookBack = std::uint64_t{1} << 63;
  bool look_back(std::uint64_t number, Instant<PhysicsClock> time, bool shape = false);
  // Answers to that which the last poll() brought.
  std::span<const StateReply> looked_back() const { return looked_back_; }

  // Starts a clock exchange, or a train of them; their stamps come out of take_sync() after a later poll().
  bool send_sync();
  std::optional<SyncStamps> take_sync();

  // Hands a person's wish to the physics server, once, as soon as it answers; false when 16 are already
  // waiting.
  bool send_control(scene::Control control);
  // Of these, how many have not been answered; controls_dropped() counts those that were not carried out.
  std::size_t controls_waiting() const { return pending_.size(); }

  // How the exchange looks from here; told with every hello.
  // What has gone wrong or right meanwhile is not kept for the next sign of life.
  void tell(const ClientFigures& figures) {
    if (figures_ && !same_trouble(figures, *figures_)) last_hello_.reset();
    figures_ = figures;
  }
  // Asks how the server is doing; status() holds the newest answer after a later poll().
  bool ask_status();
  const std::optional<ServerStatus>& status() const { return status_; }
  std::uint64_t statuses() const { return statuses_come_; }  // that have come so far

  // What the physics server shows; empty until it has been reached once. Replaced when another server takes
  // its place.
  const std::optional<scene::SceneDescription>& description() const { return description_; }
  // That have come so far: with each it is to be looked at anew.
  std::uint64_t descriptions() const { return descriptions_; }
  // Number of the server's life; 0 before the first word. A new number means it was started anew.
  std::uint64_t session() const { return session_; }

  // What the server lets this client do; empty before its first word.
  std::optional<Role> role() const { return role_; }

  bool peer_alive() const;
  // Time since anything came from the physics server; empty before the first word.
  std::optional<Duration> since_last_word() const;
  // Why the server refused a message of ours, newest.
  const std::optional<std::string>& refusal() const { return refusal_; }
  // Why the server cannot be reached, where that is known: a key not admitted, another key than expected.
  // In words for a person, and its kind.
  std::optional<std::string> trouble() const;
  std::optional<LinkTrouble> trouble_kind() const { return wire_->trouble(); }
  const ExchangeCounters& counters() const { return request_tracker_.counters(); }
  std::uint64_t controls_dropped() const { return controls_dropped_; }

 private:
  struct PendingControl {
    ControlCall call;
    Instant<GraphicsClock> made;
    std::optional<Instant<GraphicsClock>> sent;
  };
  struct SentSync {
    std::uint64_t number = 0;
    Instant<GraphicsClock> t1;
  };

  std::optional<Instant<GraphicsClock>> send(const ClientMessage& message);
  void take(const Welcome& message, const Arrival& arrival);
  void take(const StateReply& message, const Arrival& arrival);
  void take(const SyncReply& message, const Arrival& arrival);
  void take(const ControlReply& message, const Arrival& arrival);
  void take(const StatusReply& message, const Arrival& arrival);
  void take(const Refusal& message, const Arrival& arrival);
  void say_hello(Instant<GraphicsClock> now);
  void send_pending(Instant<GraphicsClock> now);

  std::unique_ptr<LinkWire> wire_;
  std::uint64_t client_;
  std::string name_;
  RequestTracker request_tracker_;
  std::optional<ArrivedState> newest_;
  std::shared_ptr<const scene::Shape> newest_shape_;
  std::vector<ArrivedState> arrived_;
  std::vector<StateReply> looked_back_;
  std::array<SentSync, 16> syncs_sent_{};
  std::uint64_t trains_ = 0;  // of clock exchanges
  std::deque<SyncStamps> syncs_done_;
  std::deque<PendingControl> pending_;
  std::uint64_t controls_made_ = 0, controls_dropped_ = 0;
  std::optional<scene::SceneDescription> description_;
  std::uint64_t session_ = 0, descriptions_ = 0;
  std::optional<Role> role_;
  std::optional<ClientFigures> figures_;
  std::uint64_t statuses_ = 0, statuses_come_ = 0;
  std::optional<ServerStatus> status_;
  std::optional<Instant<GraphicsClock>> last_hello_, last_word_;
  std::optional<Instant<GraphicsClock>> unanswered_since_;  // first thing sent since the last word
  std::optional<std::string> refusal_;
};

}  // namespace palpate::transport
