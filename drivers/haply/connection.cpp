#include "drivers/haply/connection.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "palpate/core/text.h"
#include "palpate/device/arm_kinematics.h"
#include "palpate/time/real_time.h"

namespace palpate::drivers::haply {
namespace {

using namespace std::chrono_literals;

constexpr auto kPeriod = 1ms;
constexpr auto kAnswerWithin = 100ms, kConnectWithin = 1000ms, kRetry = 500ms;
constexpr int kPriority = 70;          // below the haptic loop's, above ordinary threads
constexpr int kInventoryAnswers = 50;  // after hello() the configuration comes within so many
constexpr double kMeanShare = 1e-3;    // of the newest round trip in their mean

Vector3 vector(const std::array<double, 3>& v) { return {v[0], v[1], v[2]}; }
std::array<double, 3> list(const Vector3& v) { return {v.x(), v.y(), v.z()}; }

const ArmState* find(const ServiceState& state, const std::string& id) {
  for (const auto& arm : state.arms)
    if (id.empty() || arm.id == id) return &arm;
  return nullptr;
}

}  // namespace

HaplyArm::Connection::~Connection() {
  {
    const std::lock_guard lock(sleep_guard_);
    ending_ = true;
  }
  sleep_.notify_all();
  if (thread_.joinable()) thread_.join();
  if (socket_) static_cast<void>(socket_->send(force_command(id_, Vector3::Zero()), kAnswerWithin));
}

Expected<void> HaplyArm::Connection::begin() {
  if (auto connected = connect(); !connected) return connected;
  thread_ = std::thread([this] { run(); });
  return {};
}

// Says hello until the configuration has come and is as asked for.
Expected<void> HaplyArm::Connection::connect() {
  auto socket = web::WebSocketClient::connect(settings_.service, kConnectWithin);
  if (!socket) return tl::unexpected(socket.error());
  const auto next = [&]() -> Expected<ServiceState> {
    const auto text = (*socket)->receive(kConnectWithin);
    if (!text) return tl::unexpected(text.error());
    return read_state(*text);
  };
  auto state = next();
  if (!state) return tl::unexpected(state.error());
  const ArmState* arm = find(*state, id_);
  if (arm == nullptr)
    return refused("{}: the service has no {}; plug the arm in and switch it on", settings_.service.text(),
                   id_.empty() ? std::string("Inverse3") : "Inverse3 " + id_);
  const std::string id = arm->id;
  if (auto said = (*socket)->send(hello(id), kConnectWithin); !said) return said;
  for (int i = 0;; ++i) {
    state = next();
    if (!state) return tl::unexpected(state.error());
    arm = find(*state, id);
    if (arm == nullptr)
      return refused("{}: the arm {} has gone again; check its cable", settings_.service.text(), id);
    if (!arm->config.is_null() || i == kInventoryAnswers) break;
    if (auto said = (*socket)->send(force_command(id, Vector3::Zero()), kConnectWithin); !said) return said;
  }
  if (auto fine = check_configured(*arm); !fine) return fine;
  {
    const std::lock_guard lock(words_guard_);
    config_ = arm->config;
  }
  if (id_.empty()) id_ = id;  // before there is another thread
  socket_ = std::move(*socket);
  strength_.restart();
  last_exchange_ns_ = 0;
  connected_ns_.store(now_ns());
  take(*state, now_ns());
  lost_.store(false, std::memory_order_release);
  return {};
}

void HaplyArm::Connection::run() {
  name_and_pin_thread("palpate-haply", -1);
  if (!enter_real_time(kPriority).fifo()) sharpen_sleep();
  auto due = std::chrono::steady_clock::now();
  while (true) {
    if (!socket_) {
      if (wait_for(kRetry)) return;
      if (const auto connected = connect(); !connected) lose(connected.error());
      due = std::chrono::steady_clock::now();
      continue;
    }
    if (const auto exchanged = exchange(); !exchanged) {
      socket_.reset();
      times_lost_.fetch_add(1);
      lose(exchanged.error());
      continue;
    }
    due = std::max(due + kPeriod, std::chrono::steady_clock::now());
    std::unique_lock lock(sleep_guard_);
    if (sleep_.wait_until(lock, due, [this] { return ending_; })) return;
  }
}

bool HaplyArm::Connection::wait_for(std::chrono::nanoseconds time) {
  std::unique_lock lock(sleep_guard_);
  return sleep_.wait_for(lock, time, [this] { return ending_; });
}

void HaplyArm::Connection::lose(const Error& error) {
  const std::lock_guard lock(words_guard_);
  trouble_ = error.message;
  lost_.store(true, std::memory_order_release);
}

Expected<void> HaplyArm::Connection::exchange() {
  const std::int64_t begun = now_ns();
  if (auto said = socket_->send(force_command(id_, force_now(begun)), kAnswerWithin); !said) return said;
  const auto text = socket_->receive(kAnswerWithin);
  if (!text) return tl::unexpected(text.error());
  const std::int64_t ended = now_ns();
  const auto state = read_state(*text);
  if (!state) {
    bad_states_.fetch_add(1);
    return tl::unexpected(state.error());
  }
  if (find(*state, id_) == nullptr)
    return refused("{}: the arm {} has gone; check its cable", settings_.service.text(), id_);
  // It was measured between the two.
  take(*state, begun + (ended - begun) / 2);
  const double took = to_seconds(Duration(ended - begun)), mean = round_trip_s_.load();
  round_trip_s_.store(mean == 0.0 ? took : mean + kMeanShare * (took - mean));
  exchanges_.fetch_add(1, std::memory_order_relaxed);
  return {};
}

void HaplyArm::Connection::take(const ServiceState& state, std::int64_t stamp_ns) {
  const ArmState& arm = *find(state, id_);
  calibrated_ = arm.calibrated.value_or(true);
  powered_ = arm.powered.value_or(true);
  uncalibrated_.store(!calibrated_);
  unpowered_.store(!powered_);
  if (!calibrated_) return;  // its places mean nothing
  SampleWire wire;
  wire.stamp_ns = stamp_ns;
  wire.place = list(arm.place);
  if (!state.grips.empty()) {
    wire.gimbal = list(device::gimbal_angles(state.grips.front().orientation));
    wire.buttons = state.grips.front().buttons;
  }
  wire.tells_held = arm.force ? 1 : 0;
  if (arm.force) wire.held = list(*arm.force);
  last_sample_ns_ = stamp_ns;
  samples_.write(wire);
}

// Nothing while the arm does not know where it is, or has no power for motors.
Vector3 HaplyArm::Connection::force_now(std::int64_t now) {
  const auto since = [now](std::int64_t then) { return to_seconds(Duration(now - then)); };
  const double elapsed = last_exchange_ns_ == 0 ? 0.0 : since(last_exchange_ns_);
  last_exchange_ns_ = now;
  CommandWire wire;
  const bool any = commands_.read(wire);
  const bool stale = any && since(wire.sent_ns) > settings_.watchdog_s;
  if (stale) stale_exchanges_.fetch_add(1, std::memory_order_relaxed);
  if (!any || !calibrated_ || !powered_) {
    strength_.restart();
    return Vector3::Zero();
  }
  const bool sampled = since(last_sample_ns_) <= settings_.watchdog_s;
  const bool released = wire.sent_ns <= let_go_ns_.load();
  strength_.tick(!stale && !released && sampled, std::max(since(wire.sent_ns), since(last_sample_ns_)),
                 elapsed);
  if (released) strength_.let_go();
  return strength_.gain() * vector(wire.force);
}

device::ArmSample HaplyArm::Connection::read() const {
  device::ArmSample sample;
  SampleWire wire;
  const bool any = samples_.read(wire);
  const std::int64_t now = now_ns();
  const bool lost = lost_.load(std::memory_order_acquire);
  sample.stamp = {Duration(any ? wire.stamp_ns : now)};
  const bool fresh = any && !lost && wire.stamp_ns >= connected_ns_.load(std::memory_order_relaxed) &&
                     to_seconds(Duration(now - wire.stamp_ns)) <= settings_.watchdog_s;
  if (fresh) {
    sample.joints = {wire.place[0], wire.place[1], wire.place[2]};
    sample.gimbal = vector(wire.gimbal);
    sample.buttons = wire.buttons;
  } else {
    sample.joints.setConstant(std::numeric_limits<double>::quiet_NaN());
    sample.gimbal.setConstant(std::numeric_limits<double>::quiet_NaN());
  }
  sample.waited = std::max(Duration(0), Duration(now - sample.stamp.ns()));
  sample.connected = !lost;
  if (lost)
    sample.held = Vector3::Zero();
  else if (any && wire.tells_held != 0)
    sample.held = vector(wire.held);
  return sample;
}

void HaplyArm::Connection::command(const Vector3& force) {
  const bool usable = force.allFinite();
  if (!usable) refused_commands_.fetch_add(1, std::memory_order_relaxed);
  commands_.write({now_ns(), list(usable ? force : Vector3(Vector3::Zero()))});
}

Json HaplyArm::Connection::config() const {
  const std::lock_guard lock(words_guard_);
  return config_;
}

ArmStatus HaplyArm::Connection::status() const {
  ArmStatus status;
  status.exchanges = exchanges_.load();
  status.stale_exchanges = stale_exchanges_.load();
  status.refused_commands = refused_commands_.load();
  status.bad_states = bad_states_.load();
  status.times_lost = times_lost_.load();
  status.round_trip_s = round_trip_s_.load();
  const auto is = [&](device::HealthCode code, std::string words) {
    status.health = {code, std::move(words), "arm haply: works again"};
  };
  if (lost_.load()) {
    const std::lock_guard lock(words_guard_);
    is(device::HealthCode::arm_lost, fmt::format("arm haply: {}", trouble_));
  } else if (uncalibrated_.load()) {
    is(device::HealthCode::arm_uncalibrated,
       "arm haply: is not calibrated; put the grip on the inkwell, or move the arm as its light asks for");
  } else if (unpowered_.load()) {
    is(device::HealthCode::arm_forces_off, "arm haply: has no power for its motors; plug its supply in");
  }
  return status;
}

}  // namespace palpate::drivers::haply
