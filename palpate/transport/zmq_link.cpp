// The graphics server's ZeroMQ socket. The graphics loop sends by itself (no second thread to be woken on the
// way out); a thread waits for replies so that each is stamped when it comes, however busy the loop is, and
// checks them. Both reach the socket under one mutex, held for a few non-blocking calls; the loop takes what
// has come from a queue without it.
#include <poll.h>
#include <zmq.h>

#include <atomic>
#include <cstring>
#include <mutex>
#include <thread>

#include "palpate/core/system_error.h"
#include "palpate/time/real_time.h"
#include "palpate/transport/internal/handover_queue.h"
#include "palpate/transport/internal/server_connection.h"
#include "palpate/transport/internal/zmq_authenticator.h"
#include "palpate/transport/zmq_engine.h"
#include "palpate/transport/zmq_socket.h"

namespace palpate::transport {

namespace {

class ZmqWire : public LinkWire {
 public:
  ZmqWire(std::string address, zmq::Socket socket, zmq::Socket events, const Clock<GraphicsClock>& clock)
      : address_(std::move(address)),
        events_(std::move(events)),
        socket_(std::move(socket)),
        clock_(clock),
        thread_([this] { run(); }) {}
  ~ZmqWire() override {
    stop_.set();
    thread_.join();
  }
  ZmqWire(const ZmqWire&) = delete;
  ZmqWire& operator=(const ZmqWire&) = delete;

  Instant<GraphicsClock> now() const override { return clock_.now(); }

  std::optional<Instant<GraphicsClock>> send(const ClientMessage& message) override {
    const std::string bytes = encode(message);
    const std::lock_guard lock(mutex_);
    const auto sent = send_now(bytes);
    if (const auto* sync = std::get_if<SyncRequest>(&message); sync != nullptr && sent)
      train_ = {.awaited = sync->number, .last = sync->number + kSyncTrain - 1, .asked = std::nullopt};
    // Sending may have swallowed the signal that something has come; the thread would then sleep over it.
    if (socket_.readable()) more_.set();
    return sent;
  }

  bool take(Arrival& arrival) override {
    if (!arrivals_.pop(arrival)) return false;
    if (has_shape(arrival)) shapes_waiting_.fetch_sub(1, std::memory_order_relaxed);
    return true;
  }

  std::optional<LinkTrouble> trouble() const override {
    switch (trouble_.load(std::memory_order_relaxed)) {
      case Trouble::not_admitted:
        return LinkTrouble::not_admitted;
      case Trouble::no_place:
        return LinkTrouble::no_place;
      case Trouble::no_agreement:
        return LinkTrouble::no_agreement;
      case Trouble::flood:
        return LinkTrouble::flood;
      case Trouble::none:
        break;
    }
    return std::nullopt;
  }

 private:
  void run() {
    name_and_pin_thread("palpate-link", -1);
    ask_for_short_turns();
    pollfd items[] = {{socket_.fd(), POLLIN, 0},
                      {stop_.fd(), POLLIN, 0},
                      {events_.fd(), POLLIN, 0},
                      {more_.fd(), POLLIN, 0}};
    while (true) {
      // The time-out is a safety net, for each signal of the socket wakes the thread; and a message that does not
      // end gives none.
      ::poll(items, 4, connection_.there() ? kLookEveryMs : 100);
      if ((items[1].revents & POLLIN) != 0) return;
      if ((items[3].revents & POLLIN) != 0) more_.clear();
      take_events();
      // Bounded, so that a server that floods cannot keep the thread from its other duties.
      int received = 0;
      while (received < zmq::kMostPassedOver && receive_one()) ++received;
      if (received == zmq::kMostPassedOver) more_.set();
      if (connection_.too_much()) {
        trouble_ = Trouble::flood;
        cut_off_ = true;
        connection_.end();
      }
      begin_anew_where_given_up();
    }
  }

  // How long a message without an end may go on before somebody looks: a quick machine takes 2 MB of it a millisecond.
  static constexpr int kLookEveryMs = 5;
  // ZeroMQ tries every kReconnectMs + kConnectMs at the latest; each attempt is a sign.
  static constexpr Duration kGivenUpAfter = std::chrono::milliseconds(600);

  enum class Trouble { none, not_admitted, no_place, no_agreement, flood };

  static bool has_shape(const Arrival& arrival) {
    const auto* reply = arrival.message ? std::get_if<StateReply>(&*arrival.message) : nullptr;
    return reply != nullptr && reply->shape != nullptr;
  }

  // What ZeroMQ tells of the connection, in messages of two frames: the event's number and value, and where.
  void take_events() {
    std::string event, where;
    while (events_.receive(2, &event, where) == zmq::Socket::Received::message) {
      std::uint16_t number = 0;
      std::uint32_t value = 0;
      if (event.size() < sizeof number + sizeof value) continue;
      std::memcpy(&number, event.data(), sizeof number);
      std::memcpy(&value, event.data() + sizeof number, sizeof value);
      last_sign_ = clock_.now();
      if (number == ZMQ_EVENT_CONNECTED) connection_.began(static_cast<int>(value));
      if (number == ZMQ_EVENT_HANDSHAKE_SUCCEEDED) up_ = true;
      if (up_ && trouble_ != Trouble::flood)
        trouble_ = Trouble::none;  // of which the next good word makes an end
      if (number == ZMQ_EVENT_DISCONNECTED) up_ = false, connection_.ended();
      if (number == ZMQ_EVENT_DISCONNECTED && std::exchange(cut_off_, false)) pause();
      if (number == ZMQ_EVENT_HANDSHAKE_FAILED_AUTH)
        trouble_ = value == zmq::kNoPlace ? Trouble::no_place : Trouble::not_admitted;
      if (number == ZMQ_EVENT_HANDSHAKE_FAILED_PROTOCOL || number == ZMQ_EVENT_HANDSHAKE_FAILED_NO_DETAIL)
        trouble_ = Trouble::no_agreement;
    }
  }

  // ZeroMQ connects again by itself, but gives up for good where the other side breaks the protocol or turns
  // us away: then we begin anew, for a key may be admitted and a server replaced.
  // No new attempt before kGivenUpAfter.
  void pause() {
    const std::lock_guard lock(mutex_);
    zmq_disconnect(socket_.get(), address_.c_str());
  }
  void begin_anew_where_given_up() {
    if (up_ || clock_.now() - last_sign_ < kGivenUpAfter) return;
    last_sign_ = clock_.now();
    const std::lock_guard lock(mutex_);
    zmq_disconnect(socket_.get(), address_.c_str());  // nothing there any more, mostly
    zmq_connect(socket_.get(), address_.c_str());
  }

  // The thread's. False when nothing has come. Checking what came, which takes its time for a shape, keeps
  // nobody from sending.
  bool receive_one() {
    Arrival arrival;
    auto received = zmq::Socket::Received::nothing;
    {
      const std::lock_guard lock(mutex_);
      if (socket_.readable()) received = socket_.receive(1, nullptr, body_, nullptr, &shape_);
      arrival.received = clock_.now();
    }
    if (received == zmq::Socket::Received::nothing) return false;
    std::size_t bytes = body_.size();
    for (const zmq::Frame& piece : shape_) bytes += piece.bytes().size();
    const bool looked_at =
        connection_.count(bytes, arrival.received) &&
        (shape_.empty() || shapes_waiting_.load() < zmq::ServerConnection::kMostShapesWaiting);
    if (!looked_at) shape_.clear();
    if (received == zmq::Socket::Received::message && looked_at) {
      std::vector<std::string_view> shape;
      for (const zmq::Frame& piece : shape_) shape.push_back(piece.bytes());
      if (auto message = decode_server_message(body_, shape)) arrival.message = std::move(*message);
      shape_.clear();
    }
    if (arrival.message) trouble_ = Trouble::none;
    if (const auto* welcome = arrival.message ? std::get_if<Welcome>(&*arrival.message) : nullptr)
      if (welcome->scene)
        connection_.expect(kMaxMessageBytes +
                           welcome->scene->shape_vertices * scene::Shape::kFloatsPerVertex * sizeof(float));
    if (arrival.message)
      if (const auto* sync = std::get_if<SyncReply>(&*arrival.message)) follow_up(*sync, arrival);
    // Full when the graphics loop has stopped for seconds; what is dropped then is counted as lost.
    const bool shape = has_shape(arrival);
    if (shape) shapes_waiting_.fetch_add(1, std::memory_order_relaxed);
    if (!arrivals_.push(std::move(arrival)) && shape) shapes_waiting_.fetch_sub(1, std::memory_order_relaxed);
    return true;
  }

  // With the mutex held.
  std::optional<Instant<GraphicsClock>> send_now(const std::string& bytes) {
    const Instant<GraphicsClock> sent = clock_.now();
    if (!socket_.send(bytes)) return std::nullopt;
    return sent;
  }

  // The first question wakes every thread on its way, while its answer comes back through some that have just
  // run; those that follow at once find all awake, which makes both ways quick and alike.
  void follow_up(const SyncReply& reply, Arrival& arrival) {
    const std::lock_guard lock(mutex_);
    if (reply.number != train_.awaited) return;
    arrival.asked = train_.asked;
    train_.awaited = 0;
    if (reply.number >= train_.last) return;
    train_.asked = send_now(encode(SyncRequest{reply.number + 1}));
    if (train_.asked) train_.awaited = reply.number + 1;
  }

  // Clock questions that follow each other: the one an answer is due to, and when it left if this thread
  // asked.
  struct SyncTrainUnderWay {
    std::uint64_t awaited = 0, last = 0;
    std::optional<Instant<GraphicsClock>> asked;
  };

  std::string address_;
  zmq::Socket events_;  // of the connection; the thread's alone
  std::atomic<Trouble> trouble_{Trouble::none};
  zmq::Socket socket_;
  const Clock<GraphicsClock>& clock_;
  // Of the thread alone: the connection, whether it stands, whether we have ended it, and the last attempt at it.
  zmq::ServerConnection connection_;
  bool up_ = false, cut_off_ = false;
  Instant<GraphicsClock> last_sign_ = clock_.now();
  std::mutex mutex_;
  std::string body_;  // the thread's, like the next
  std::vector<zmq::Frame> shape_;
  SyncTrainUnderWay train_;
  HandoverQueue<Arrival, 128> arrivals_;
  std::atomic<int> shapes_waiting_{0};  // in it
  zmq::Stop stop_, more_;               // more_: something may have come without a signal
  std::thread thread_;
};

// What becomes of the connection's handshakes, as messages.
Expected<zmq::Socket> watch_handshakes(zmq::Socket& socket, const zmq::Context& context) {
  constexpr const char* kPlace = "inproc://handshakes";
  constexpr int kEvents = ZMQ_EVENT_CONNECTED | ZMQ_EVENT_CONNECT_DELAYED | ZMQ_EVENT_CONNECT_RETRIED |
                          ZMQ_EVENT_DISCONNECTED | ZMQ_EVENT_HANDSHAKE_SUCCEEDED |
                          ZMQ_EVENT_HANDSHAKE_FAILED_AUTH | ZMQ_EVENT_HANDSHAKE_FAILED_PROTOCOL |
                          ZMQ_EVENT_HANDSHAKE_FAILED_NO_DETAIL;
  auto events = zmq::Socket::make(ZMQ_PAIR, context);
  if (!events) return tl::unexpected(events.error());
  if (zmq_socket_monitor(socket.get(), kPlace, kEvents) != 0 || zmq_connect(events->get(), kPlace) != 0)
    return refused("ZeroMQ tells nothing of its connections: {}", reason_of(errno));
  return events;
}

}  // namespace

Expected<std::unique_ptr<StateLink>> connect_states(const Endpoint& endpoint,
                                                    const Clock<GraphicsClock>& clock, std::string name,
                                                    const std::optional<ClientIdentity>& identity) {
  if (endpoint.encrypted && !identity)
    return wrong_use("{}: this machine's keys and the server's are needed to connect there",
                     endpoint.address);
  const auto context = zmq::make_context();
  if (!context) return tl::unexpected(context.error());
  auto socket = zmq::Socket::make(ZMQ_DEALER, *context);
  if (!socket) return tl::unexpected(socket.error());
  if (endpoint.encrypted)
    if (auto done = zmq::encrypt(*socket, *identity); !done) return tl::unexpected(done.error());
  // Bounded by ServerConnection.
  if (!socket->receive_without_bound())
    return refused("ZeroMQ refuses a socket option: {}", reason_of(errno));
  auto events = watch_handshakes(*socket, *context);
  if (!events) return tl::unexpected(events.error());
  if (zmq_connect(socket->get(), endpoint.address.c_str()) != 0) {
    return refused("{}: cannot connect there: {}", endpoint.address, reason_of(errno));
  }
  try {
    return std::make_unique<StateLink>(
        std::make_unique<ZmqWire>(endpoint.address, std::move(*socket), std::move(*events), clock),
        zmq::new_name("network/client"), std::move(name));
  } catch (const std::exception& failure) {
    return refused("{}: the link cannot start: {}", endpoint.address, failure.what());
  }
}

}  // namespace palpate::transport
