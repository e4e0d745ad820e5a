#include <zmq.h>

#include <atomic>
#include <cerrno>
#include <thread>
#include <utility>

#include "palpate/time/real_time.h"
#include "palpate/transport/internal/rate_limit.h"
#include "palpate/transport/internal/service_core.h"
#include "palpate/transport/internal/zmq_authenticator.h"
#include "palpate/transport/internal/zmq_connection_guard.h"
#include "palpate/transport/internal/zmq_publisher.h"
#include "palpate/transport/zmq_engine.h"
#include "palpate/transport/zmq_socket.h"

namespace palpate::transport {

namespace {

// What clients say: a Hello of whom everything fails takes 1 KiB. Who sends more loses the connection before it is
// in memory.
constexpr std::size_t kMaxQuestionBytes = 4096;

class ZmqService : public StateService {
 public:
  ZmqService(zmq::Socket socket, std::unique_ptr<zmq::ConnectionGuard> guard,
             std::optional<zmq::Authenticator> authenticator, std::optional<SocketClaim> claim,
             const Clock<PhysicsClock>& clock, StateSource source, scene::SceneDescription scene)
      : claim_(std::move(claim)),
        authenticator_(std::move(authenticator)),
        guard_(std::move(guard)),
        socket_(std::move(socket)),
        endpoint_(socket_.endpoint()),
        clock_(clock),
        core_(std::move(source), std::move(scene), zmq::new_name("network/session"),
              [&clock] { return clock.now(); }) {}
  ~ZmqService() override {
    stop_.set();
    if (thread_.joinable()) thread_.join();
    guard_->leave(socket_);
  }
  ZmqService(const ZmqService&) = delete;
  ZmqService& operator=(const ZmqService&) = delete;

  std::optional<scene::Control> take_control() override { return core_.take_control(); }
  ServiceCounters counters() const override {
    ServiceCounters counters = core_.counters();
    counters.rejected_connections = rejected_connections_.load(std::memory_order_relaxed);
    return counters;
  }
  std::string endpoint() const override { return endpoint_; }
  std::string states_endpoint() const override { return publisher_ ? publisher_->endpoint() : std::string(); }

  // Before the first client comes.
  Expected<void> publish(const zmq::Context& context, const Endpoint& endpoint, const StateSource& source) {
    auto publisher = zmq::Publisher::make(context, endpoint, *guard_,
                                          authenticator_ ? &*authenticator_ : nullptr, clock_, source);
    if (!publisher) return tl::unexpected(publisher.error());
    publisher_ = std::move(*publisher);
    core_.set_states_endpoint(publisher_->endpoint());
    return {};
  }
  void set_shape_source(ShapeSource shape) { core_.set_shape_source(std::move(shape)); }
  void set_status_source(StatusSource status) { core_.set_status_source(std::move(status)); }
  void start() {
    thread_ = std::thread([this] { run(); });
  }

 private:
  static constexpr long kCountEveryMs = 100;
  static constexpr int kMessages_hz = 20'000;  // of one connection; a graphics server sends some hundred

  void run() {
    name_and_pin_thread("palpate-net", -1);
    ask_for_short_turns();
    zmq_pollitem_t items[] = {{socket_.get(), 0, ZMQ_POLLIN, 0},
                              {nullptr, stop_.fd(), ZMQ_POLLIN, 0},
                              {authenticator_ ? authenticator_->get() : nullptr, -1, ZMQ_POLLIN, 0}};
    const int count = authenticator_ ? 3 : 2;
    while (true) {
      const int ready = zmq_poll(items, count, kCountEveryMs);
      if (ready < 0 && errno != EINTR) return;  // the context has gone
      if (ready > 0 && (items[1].revents & ZMQ_POLLIN) != 0) return;
      if (ready > 0 && (items[0].revents & ZMQ_POLLIN) != 0) answer_what_has_come();
      if (authenticator_) {
        authenticator_->answer([this](const std::string& key) { return guard_->full(key); });
        rejected_connections_.store(authenticator_->rejected_connections(), std::memory_order_relaxed);
        if (authenticator_->look_again(clock_.now().since_epoch) && publisher_) publisher_->check_keys();
      }
      if (publisher_) add_the_publishers_counts();
      core_.set_counts(rejected_connections_.load(std::memory_order_relaxed),
                       publisher_ ? publisher_->published() : 0);
      core_.count_clients();
    }
  }

  void add_the_publishers_counts() {
    const std::uint64_t rejected = publisher_->rejected(), unsent = publisher_->unsent();
    core_.rejected(rejected - std::exchange(states_rejected_, rejected));
    core_.unsent(unsent - std::exchange(states_unsent_, unsent));
  }

  void answer_what_has_come() {
    // Bounded, so that a flood cannot keep the thread from its other duties.
    for (int answered = 0, passed_over = 0;
         answered < zmq::kQueueLength && passed_over < zmq::kMostPassedOver;) {
      const auto received = socket_.receive(2, &peer_, body_, &sender_);
      const Instant<PhysicsClock> now = clock_.now();
      if (received == zmq::Socket::Received::nothing) return;
      const auto share = limit_.count(peer_, body_.size(), now);
      const bool admitted = share == RateLimit::Share::within;
      if (share == RateLimit::Share::flood) guard_->cut_off(sender_);
      ++(admitted ? answered : passed_over);
      const auto role = authenticator_ ? authenticator_->role_of(sender_.user) : Role::operator_;
      if (received == zmq::Socket::Received::rejected || !admitted ||
          !guard_->heard(sender_, role == Role::operator_)) {
        core_.rejected();
        continue;
      }
      // A peer that has gone or does not take its mail loses the answer; nobody waits for it.
      const ServerMessage answer = core_.answer(body_, now, role, peer_, sender_.user);
      const auto shape = shape_of(answer);
      if (!socket_.send(peer_, true) || !socket_.send(encode(answer), shape != nullptr) ||
          (shape && !send_shape(shape)))
        core_.unsent();
    }
  }

  bool send_shape(const std::shared_ptr<const scene::Shape>& shape) {
    const auto pieces = shape_pieces(*shape, authenticator_ ? kShapePieceBytes : kMaxShapeBytes);
    for (const std::string_view& piece : pieces)
      if (!socket_.send(piece, shape, &piece != &pieces.back())) return false;
    return true;
  }

  // Destroyed from below: the thread has ended, the socket closes, and only then is the address given up.
  std::optional<SocketClaim> claim_;
  std::optional<zmq::Authenticator> authenticator_;
  std::unique_ptr<zmq::ConnectionGuard> guard_;
  zmq::Socket socket_;
  std::string endpoint_;
  const Clock<PhysicsClock>& clock_;
  ServiceCore core_;
  std::unique_ptr<zmq::Publisher> publisher_;
  std::atomic<std::uint64_t> rejected_connections_{0};
  std::uint64_t states_rejected_ = 0, states_unsent_ = 0;  // of the publisher, counted so far
  zmq::Stop stop_;
  RateLimit limit_{kMessages_hz, 3 * kMessages_hz / 2};
  std::string peer_, body_;
  zmq::Sender sender_;
  std::thread thread_;
};

Expected<std::unique_ptr<StateService>> serve_once(const Endpoint& endpoint, const Clock<PhysicsClock>& clock,
                                                   const StateSource& source,
                                                   const scene::SceneDescription& scene,
                                                   const ServiceOptions& options) {
  std::optional<SocketClaim> claim;
  if (endpoint.local()) {
    auto taken = SocketClaim::take(endpoint.socket);
    if (!taken) return tl::unexpected(taken.error());
    claim = std::move(*taken);
  }
  const auto context = zmq::make_context();
  if (!context) return tl::unexpected(context.error());
  auto guard = zmq::ConnectionGuard::make(clock);
  if (!guard) return tl::unexpected(guard.error());
  auto socket = zmq::Socket::make(ZMQ_ROUTER, *context, kMaxQuestionBytes);
  if (!socket) return tl::unexpected(socket.error());
  if (auto watched = (*guard)->watch(*socket, *context); !watched) return tl::unexpected(watched.error());
  std::optional<zmq::Authenticator> authenticator;
  if (endpoint.encrypted) {
    auto made = zmq::Authenticator::make(*context, *options.identity);
    if (!made) return tl::unexpected(made.error());
    if (auto guarded = made->guard(*socket); !guarded) return tl::unexpected(guarded.error());
    authenticator.emplace(std::move(*made));
  }
  if (auto bound = socket->bind(endpoint.address); !bound) return tl::unexpected(bound.error());
  const auto states = states_endpoint({socket->endpoint(), endpoint.socket, endpoint.encrypted});
  if (!states) return tl::unexpected(states.error());
  auto service = std::make_unique<ZmqService>(std::move(*socket), std::move(*guard), std::move(authenticator),
                                              std::move(claim), clock, source, scene);
  if (auto published = service->publish(*context, *states, source); !published)
    return tl::unexpected(published.error());
  service->set_status_source(options.status);
  service->set_shape_source(options.shape);
  service->start();
  return service;
}

}  // namespace

Expected<std::unique_ptr<StateService>> serve_states(const Endpoint& endpoint,
                                                     const Clock<PhysicsClock>& clock, StateSource source,
                                                     scene::SceneDescription scene,
                                                     const ServiceOptions& options) {
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

}  // namespace palpate::transport
