#include <zmq.h>

#include <atomic>
#include <cerrno>
#include <thread>

#include "palpate/network/service_core.h"
#include "palpate/network/zmq_engine.h"
#include "palpate/network/zmq_gate.h"
#include "palpate/network/zmq_publisher.h"
#include "palpate/network/zmq_socket.h"
#include "palpate/time/real_time.h"

namespace palpate {

namespace {

class ZmqService : public StateService {
 public:
  ZmqService(zmq::Socket socket, std::optional<zmq::Gate> gate, std::optional<SocketClaim> claim,
             const Clock<PhysicsClock>& clock, StateSource source, SceneDescription scene)
      : claim_(std::move(claim)),
        gate_(std::move(gate)),
        socket_(std::move(socket)),
        endpoint_(socket_.endpoint()),
        clock_(clock),
        core_(std::move(source), std::move(scene), zmq::new_name("network/session"),
              [&clock] { return clock.now(); }) {}
  ~ZmqService() override {
    stop_.set();
    if (thread_.joinable()) thread_.join();
  }
  ZmqService(const ZmqService&) = delete;
  ZmqService& operator=(const ZmqService&) = delete;

  std::optional<Control> take_control() override { return core_.take_control(); }
  ServiceCounters counters() const override {
    ServiceCounters counters = core_.counters();
    counters.turned_away = turned_away_.load(std::memory_order_relaxed);
    return counters;
  }
  std::string endpoint() const override { return endpoint_; }
  std::string states_endpoint() const override { return publisher_ ? publisher_->endpoint() : std::string(); }

  // Before the first client comes.
  Expected<void> publish(const zmq::Context& context, const Endpoint& endpoint, const StateSource& source) {
    auto publisher = zmq::Publisher::make(context, endpoint, gate_ ? &*gate_ : nullptr, clock_, source);
    if (!publisher) return tl::unexpected(publisher.error());
    publisher_ = std::move(*publisher);
    core_.publishes_at(publisher_->endpoint());
    return {};
  }
  void shows(ShapeSource shape) { core_.shows(std::move(shape)); }
  void tells_of(StatusSource status) { core_.tells_of(std::move(status)); }
  void start() {
    thread_ = std::thread([this] { run(); });
  }

 private:
  static constexpr long kCountEveryMs = 100;

  void run() {
    name_and_pin_thread("palpate-net", -1);
    ask_for_short_turns();
    zmq_pollitem_t items[] = {{socket_.get(), 0, ZMQ_POLLIN, 0},
                              {nullptr, stop_.fd(), ZMQ_POLLIN, 0},
                              {gate_ ? gate_->get() : nullptr, -1, ZMQ_POLLIN, 0}};
    const int count = gate_ ? 3 : 2;
    while (true) {
      const int ready = zmq_poll(items, count, kCountEveryMs);
      if (ready < 0 && errno != EINTR) return;  // the context has gone
      if (ready > 0 && (items[1].revents & ZMQ_POLLIN) != 0) return;
      if (ready > 0 && (items[0].revents & ZMQ_POLLIN) != 0) answer_what_has_come();
      if (gate_) {
        gate_->answer();
        turned_away_.store(gate_->turned_away(), std::memory_order_relaxed);
        if (gate_->look_again(clock_.now().since_epoch) && publisher_) publisher_->begin_anew();
      }
      if (publisher_ && publisher_->floods() > floods_) core_.rejected(), ++floods_;
      core_.counts(turned_away_.load(std::memory_order_relaxed), publisher_ ? publisher_->published() : 0);
      core_.count_clients();
    }
  }

  void answer_what_has_come() {
    // Bounded, so that a flood cannot keep the thread from its other duties.
    for (int i = 0; i < zmq::kQueueLength; ++i) {
      const auto received = socket_.receive(2, &peer_, body_, &user_);
      const Instant<PhysicsClock> now = clock_.now();
      if (received == zmq::Socket::Received::nothing) return;
      if (received == zmq::Socket::Received::rejected) {
        core_.rejected();
        continue;
      }
      // A peer that has gone or does not take its mail loses the answer; nobody waits for it.
      const auto role = gate_ ? gate_->role_of(user_) : Role::operator_;
      const ServerMessage answer = core_.answer(body_, now, role, peer_, user_);
      const auto shape = shape_of(answer);
      if (!socket_.send(peer_, true) || !socket_.send(encode(answer), shape != nullptr) ||
          (shape && !send_shape(shape)))
        core_.unsent();
    }
  }

  bool send_shape(const std::shared_ptr<const Shape>& shape) {
    const auto pieces = shape_pieces(*shape, gate_ ? kShapePieceBytes : kMaxShapeBytes);
    for (const std::string_view& piece : pieces)
      if (!socket_.send(piece, shape, &piece != &pieces.back())) return false;
    return true;
  }

  // Destroyed from below: the thread has ended, the socket closes, and only then is the address given up.
  std::optional<SocketClaim> claim_;
  std::optional<zmq::Gate> gate_;
  zmq::Socket socket_;
  std::string endpoint_;
  const Clock<PhysicsClock>& clock_;
  ServiceCore core_;
  std::unique_ptr<zmq::Publisher> publisher_;
  std::atomic<std::uint64_t> turned_away_{0};
  std::uint64_t floods_ = 0;  // that have been counted as rejected
  zmq::Stop stop_;
  std::string peer_, body_, user_;
  std::thread thread_;
};

Expected<std::unique_ptr<StateService>> serve_once(const Endpoint& endpoint, const Clock<PhysicsClock>& clock,
                                                   const StateSource& source, const SceneDescription& scene,
                                                   const ServiceOptions& options) {
  std::optional<SocketClaim> claim;
  if (endpoint.local()) {
    auto taken = SocketClaim::take(endpoint.socket);
    if (!taken) return tl::unexpected(taken.error());
    claim = std::move(*taken);
  }
  const auto context = zmq::make_context();
  if (!context) return tl::unexpected(context.error());
  auto socket = zmq::Socket::make(ZMQ_ROUTER, *context);
  if (!socket) return tl::unexpected(socket.error());
  std::optional<zmq::Gate> gate;
  if (endpoint.encrypted) {
    auto made = zmq::Gate::make(*context, *options.identity);
    if (!made) return tl::unexpected(made.error());
    if (auto guarded = made->guard(*socket); !guarded) return tl::unexpected(guarded.error());
    gate.emplace(std::move(*made));
  }
  if (auto bound = socket->bind(endpoint.address); !bound) return tl::unexpected(bound.error());
  const auto states = states_endpoint({socket->endpoint(), endpoint.socket, endpoint.encrypted});
  if (!states) return tl::unexpected(states.error());
  auto service = std::make_unique<ZmqService>(std::move(*socket), std::move(gate), std::move(claim), clock,
                                              source, scene);
  if (auto published = service->publish(*context, *states, source); !published)
    return tl::unexpected(published.error());
  service->tells_of(options.status);
  service->shows(options.shape);
  service->start();
  return service;
}

}  // namespace

Expected<std::unique_ptr<StateService>> serve_states(const Endpoint& endpoint,
                                                     const Clock<PhysicsClock>& clock, StateSource source,
                                                     SceneDescription scene, const ServiceOptions& options) {
  if (endpoint.encrypted && !options.identity)
    return wrong_use("{}: this machine's keys are needed to listen there", endpoint.address);
  // Where the system chooses the port, the one above may be taken, where the states would go: then another
  // pair.
  int attempts = !endpoint.local() && endpoint.address.ends_with(":0") ? 20 : 1;
  try {
    while (true) {
      auto service = serve_once(endpoint, clock, source, scene, options);
      if (service || --attempts == 0) return service;
    }
  } catch (const std::exception& failure) {
    return refused("{}: the server cannot start: {}", endpoint.address, failure.what());
  }
}

}  // namespace palpate
