#include "palpate/server/session/session.h"

#include <fmt/format.h>
#include <unistd.h>

#include <future>
#include <mutex>
#include <stdexcept>
#include <thread>
#include <utility>
#include <vector>

#include "palpate/core/log.h"
#include "palpate/device/health_monitor.h"
#include "palpate/render/context.h"
#include "palpate/server/physics/guest_news.h"
#include "palpate/server/session/graphics_side.h"
#include "palpate/transport/zmq_engine.h"

namespace palpate::server::session {
namespace {
constexpr Log kSessionLog("session");
}

// The frame loop: everything of the graphics side is made, used and taken down on its thread.
class FrameLoop {
 public:
  FrameLoop(const SessionSetup& setup, transport::Endpoint endpoint, scene::SceneDescription scene,
            std::function<void(const graphics::FrameRecord&)> shown)
      : setup_(graphics_setup(setup)),
        pipeline_(setup.pipeline),
        endpoint_(std::move(endpoint)),
        scene_(std::move(scene)),
        shown_(std::move(shown)) {}
  ~FrameLoop() { stop(); }

  // Waits until the devices are open.
  Expected<void> start() {
    std::promise<Expected<void>> begun;
    auto answer = begun.get_future();
    thread_ = std::thread([this, &begun] { run(begun); });
    return answer.get();
  }
  void stop() {
    stopping_ = true;
    if (thread_.joinable()) thread_.join();
  }
  Expected<void> trouble() const {
    const std::lock_guard lock(mutex_);
    return trouble_;
  }
  void control(scene::Control wish) {
    const std::lock_guard lock(mutex_);
    wishes_.push_back(wish);
  }
  std::uint64_t frames() const { return frames_; }

 private:
  void run(std::promise<Expected<void>>& begun) {
    std::shared_ptr<render::Context> drawing;  // outlives those who draw
    auto side = made(drawing);
    begun.set_value(side ? Expected<void>() : Expected<void>(tl::unexpected(side.error())));
    if (!side) return;
    auto next = clock_.now(), draw_at = next;
    while (!stopping_) {
      next = std::max(next + std::chrono::milliseconds(1), clock_.now());
      std::this_thread::sleep_for(next - clock_.now());
      tick(**side, draw_at);
    }
  }

  // What GraphicsServer throws for a rig that lacks something is a refusal here: nobody else would catch it.
  Expected<std::unique_ptr<GraphicsSide>> made(std::shared_ptr<render::Context>& drawing) {
    try {
      return make(drawing);
    } catch (const std::invalid_argument& error) {
      return refused("session: {}", error.what());
    }
  }

  Expected<std::unique_ptr<GraphicsSide>> make(std::shared_ptr<render::Context>& drawing) {
    if (pipeline_ == nullptr && setup_.pixels == Pixels::drawn) {
      auto context = render::Context::of_this_thread();
      if (!context) return refused("session: {}", context.error().message);
      drawing = std::move(*context);
    }
    auto devices = GraphicsDevices::open(setup_);
    if (!devices) return tl::unexpected(devices.error());
    auto link = transport::connect_states(endpoint_, clock_, "session");
    if (!link) return tl::unexpected(link.error());
    auto side = GraphicsSide::make(setup_, std::move(*devices), std::move(*link), scene_, pipeline_);
    if (side) {
      (*side)->server().set_log(kSessionLog);
      (*side)->server().set_clock(clock_);
    }
    return side;
  }

  void tick(GraphicsSide& side, Instant<GraphicsClock>& draw_at) {
    if (auto there = side.devices().look(); !there) {
      const std::lock_guard lock(mutex_);
      trouble_ = there;
    }
    if (auto* camera = side.devices().live_camera()) side.server().set_camera_health(camera->health());
    side.service(clock_.now());
    for (const auto wish : take_wishes()) side.link().send_control(wish);
    if (side.begin(clock_.now())) {
      draw_at = clock_.now() + GraphicsSide::kDrawAfter;
    } else if (side.server().frame_begun() && clock_.now() >= draw_at) {
      const graphics::FrameRecord& frame = side.finish(clock_.now());
      if (shown_) shown_(frame);
      ++frames_;
    }
    side.lead_hand(clock_.now());
  }

  std::vector<scene::Control> take_wishes() {
    const std::lock_guard lock(mutex_);
    return std::exchange(wishes_, {});
  }

  const GraphicsSetup setup_;
  graphics::FramePipeline* pipeline_;
  const transport::Endpoint endpoint_;
  const scene::SceneDescription scene_;
  const std::function<void(const graphics::FrameRecord&)> shown_;
  const MonotonicClock<GraphicsClock> clock_;
  std::atomic<bool> stopping_{false};
  std::atomic<std::uint64_t> frames_{0};
  mutable std::mutex mutex_;
  Expected<void> trouble_;
  std::vector<scene::Control> wishes_;
  std::thread thread_;
};

// The loops end first: everything they touch is declared before them.
struct Session::Parts {
  MonotonicClock<PhysicsClock> clock;
  MachineThreadClock guests_clock;
  std::unique_ptr<physics::PhysicsSide> physics;
  std::optional<physics::PhysicsLoops> loops;
  std::optional<FrameLoop> frames;
  physics::GuestNews guests;
  device::HealthMonitor<PhysicsClock> arm_health{kSessionLog};
  Instant<PhysicsClock> begun;
  std::string endpoint;
};

Session::Session(std::unique_ptr<Parts> parts) : parts_(std::move(parts)) {}
Session::~Session() { stop(); }

Expected<std::unique_ptr<Session>> Session::start(const SessionSetup& setup, const RealTime& how) {
  auto endpoint = how.endpoint.empty()
                      ? transport::default_endpoint(fmt::format("session-{}", ::getpid()))
                      : transport::parse_endpoint(how.endpoint, transport::EndpointUse::listen);
  if (!endpoint) return tl::unexpected(endpoint.error());
  if (endpoint->encrypted)
    return wrong_use("session: its endpoint is {}; ipc:// is expected (`palpate physics` serves tcp://)",
                     endpoint->address);
  auto parts = std::make_unique<Parts>();
  auto physics = physics::PhysicsSide::open(setup.physics, &parts->guests_clock);
  if (!physics) return tl::unexpected(physics.error());
  parts->physics = std::move(*physics);
  if (auto served = parts->physics->serve(*endpoint, parts->clock); !served)
    return tl::unexpected(served.error());
  parts->endpoint = endpoint->address;
  if (const std::string& words = parts->physics->server().haptic().permit().words(); !words.empty())
    kSessionLog.write(LogLevel::warning, words);
  device::OpenedArm& arm = parts->physics->arm();
  if (const auto who = arm.description(); !who.empty() && !arm.health())
    kSessionLog.write(LogLevel::info, who);
  parts->frames.emplace(setup, *endpoint, parts->physics->scene(), how.shown);
  if (auto begun = parts->frames->start(); !begun) return tl::unexpected(begun.error());
  parts->begun = parts->clock.now();
  parts->loops.emplace(*parts->physics, parts->clock,
                       physics::LoopRates{.physics_hz = setup.physics.physics_hz,
                                          .haptic_hz = setup.physics.haptic_hz,
                                          .real_time = how.real_time});
  return std::unique_ptr<Session>(new Session(std::move(parts)));
}

Expected<void> Session::look() {
  if (!parts_->loops) return {};
  parts_->loops->write_status(to_seconds(parts_->clock.now() - parts_->begun));
  const physics::GuestNews::Line guests =
      parts_->guests.look(parts_->physics->server(), parts_->loops->watchdog().hangs());
  if (guests.last) return refused("session: {}", guests.text);
  device::OpenedArm& arm = parts_->physics->arm();
  if (const auto there = arm.look(); !there) return refused("session: {}", there.error().message);
  parts_->arm_health.follow(arm.health(), parts_->clock.now());
  if (auto fine = parts_->frames->trouble(); !fine) return refused("session: {}", fine.error().message);
  if (!guests.text.empty()) kSessionLog.write(LogLevel::warning, guests.text);
  return {};
}

void Session::stop() {
  if (parts_->frames) parts_->frames->stop();
  if (parts_->loops) parts_->loops->stop();
}

void Session::control(scene::Control wish) { parts_->frames->control(wish); }
std::uint64_t Session::frames() const { return parts_->frames->frames(); }
const std::string& Session::endpoint() const { return parts_->endpoint; }
const physics::PhysicsSide& Session::physics() const { return *parts_->physics; }

}  // namespace palpate::server::session
