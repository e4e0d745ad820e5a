#include "palpate/transport/in_process.h"

#include <cmath>
#include <deque>
#include <map>
#include <utility>

#include "palpate/core/random.h"
#include "palpate/transport/internal/service_core.h"

namespace palpate::transport {

struct InProcessNetwork::Net {
  struct Line {  // one link's two directions
    Line(std::uint64_t seed, int id, Role client)
        : role(client),
          random{Random(seed, fmt::format("network/{}/to physics", id)),
                 Random(seed, fmt::format("network/{}/to graphics", id))} {}
    Role role;
    std::array<Random, 2> random;
    std::array<Instant<TrueTime>, 2> last{};  // when the latest message kept in order arrives
    std::deque<Arrival> inbox;
  };
  struct Event {
    int line = 0;
    bool to_physics = false;
    std::string bytes;
    std::shared_ptr<const scene::Shape> shape;
    std::uint64_t session = 0;  // to physics: the server it was sent to
  };

  ChannelModel model;
  std::uint64_t seed = 0;
  PhysicsTime physics_time;
  GraphicsTime graphics_time;
  Instant<TrueTime> now;
  std::map<int, Line> lines;  // by number, in a fixed order
  int lines_made = 0;
  std::map<std::pair<Instant<TrueTime>, std::uint64_t>, Event> events;  // by time, then by order of sending
  std::uint64_t sent = 0;
  ServiceCore* server = nullptr;
  std::uint64_t session = 0;

  void send(Event event) {
    const auto found = lines.find(event.line);
    if (found == lines.end()) return;
    Line& line = found->second;
    const std::size_t direction = event.to_physics ? 0 : 1;
    Random& random = line.random[direction];
    // Always the same number of draws, so that switching one fault on leaves all others as they were.
    const Duration first = delay(random), second = delay(random);
    const bool lost = random.chance(model.loss);
    const bool twice = random.chance(model.duplication);
    const bool held = random.chance(model.reordering);
    if (twice) events.emplace(std::pair(now + first + second, ++sent), event);
    if (lost) return;
    Instant<TrueTime> due = now + first;
    if (held) {
      due += model.held_back;
    } else {
      due = line.last[direction] = std::max(due, line.last[direction]);
    }
    events.emplace(std::pair(due, ++sent), std::move(event));
  }

  Duration delay(Random& random) const {
    return model.delay + seconds(-to_seconds(model.jitter) * std::log(1.0 - random.uniform()));
  }

  void deliver(Event event) {
    if (!event.to_physics) {
      const auto line = lines.find(event.line);
      if (line == lines.end()) return;
      Arrival arrival{graphics_time(now), std::nullopt, std::nullopt};
      const auto pieces = event.shape ? shape_pieces(*event.shape) : std::vector<std::string_view>();
      if (auto message = decode_server_message(event.bytes, pieces)) arrival.message = std::move(*message);
      line->second.inbox.push_back(std::move(arrival));
      return;
    }
    if (server == nullptr || event.session != session) return;  // it died on the way
    const auto line = lines.find(event.line);
    if (line == lines.end()) return;  // so did the client
    const ServerMessage answer =
        server->answer(event.bytes, physics_time(now), line->second.role, std::to_string(event.line));
    Event back{.line = event.line, .to_physics = false, .bytes = encode(answer)};
    back.shape = shape_of(answer);
    send(std::move(back));
  }
};

class InProcessNetwork::Wire : public LinkWire {
 public:
  Wire(std::shared_ptr<Net> net, int line) : net_(std::move(net)), line_(line) {}
  ~Wire() override { net_->lines.erase(line_); }
  Wire(const Wire&) = delete;
  Wire& operator=(const Wire&) = delete;

  Instant<GraphicsClock> now() const override { return net_->graphics_time(net_->now); }
  std::optional<Instant<GraphicsClock>> send(const ClientMessage& message) override {
    if (net_->server == nullptr) return std::nullopt;
    net_->send({.line = line_, .to_physics = true, .bytes = encode(message), .session = net_->session});
    return now();
  }
  bool take(Arrival& arrival) override {
    std::deque<Arrival>& inbox = net_->lines.at(line_).inbox;
    if (inbox.empty()) return false;
    arrival = std::move(inbox.front());
    inbox.pop_front();
    return true;
  }

 private:
  std::shared_ptr<Net> net_;
  int line_;
};

class InProcessNetwork::Service : public StateService {
 public:
  Service(std::shared_ptr<Net> net, StateSource source, scene::SceneDescription scene, ShapeSource shape,
          StatusSource status)
      : net_(std::move(net)), core_(std::move(source), std::move(scene), ++net_->session, [n = net_.get()] {
          return n->physics_time(n->now);
        }) {
    core_.set_shape_source(std::move(shape));
    core_.set_status_source(std::move(status));
    net_->server = &core_;
  }
  ~Service() override { net_->server = nullptr; }
  Service(const Service&) = delete;
  Service& operator=(const Service&) = delete;

  std::optional<scene::Control> take_control() override { return core_.take_control(); }
  ServiceCounters counters() const override { return core_.counters(); }
  std::string endpoint() const override { return "in-process"; }

 private:
  std::shared_ptr<Net> net_;
  ServiceCore core_;
};

InProcessNetwork::InProcessNetwork(ChannelModel model, std::uint64_t seed, PhysicsTime physics_time,
                                   GraphicsTime graphics_time)
    : net_(std::make_shared<Net>()) {
  net_->model = model;
  net_->seed = seed;
  net_->physics_time = std::move(physics_time);
  net_->graphics_time = std::move(graphics_time);
}

Expected<std::unique_ptr<StateService>> InProcessNetwork::serve(StateSource source,
                                                                scene::SceneDescription scene,
                                                                ShapeSource shape, StatusSource status) {
  if (net_->server != nullptr) return refused("in-process network: a physics server is running here already");
  return std::make_unique<Service>(net_, std::move(source), std::move(scene), std::move(shape),
                                   std::move(status));
}

std::unique_ptr<StateLink> InProcessNetwork::connect(std::string name, Role role) {
  const int line = ++net_->lines_made;
  net_->lines.emplace(line, Net::Line(net_->seed, line, role));
  return std::make_unique<StateLink>(std::make_unique<Wire>(net_, line), static_cast<std::uint64_t>(line),
                                     std::move(name));
}

void InProcessNetwork::advance_to(Instant<TrueTime> now) {
  while (!net_->events.empty() && net_->events.begin()->first.first <= now) {
    auto due = net_->events.extract(net_->events.begin());
    net_->now = std::max(net_->now, due.key().first);
    net_->deliver(std::move(due.mapped()));
  }
  net_->now = std::max(net_->now, now);
  if (net_->server != nullptr) net_->server->count_clients();
}

Instant<TrueTime> InProcessNetwork::now() const { return net_->now; }

void InProcessNetwork::set_model(const ChannelModel& model) { net_->model = model; }

}  // namespace palpate::transport
