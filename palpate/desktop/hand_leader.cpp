#include "palpate/desktop/hand_leader.h"

#include <utility>

#include "palpate/time/real_time.h"

namespace palpate::desktop {
namespace {
constexpr Duration kLeadEvery = std::chrono::milliseconds(1);
}  // namespace

HandLeader::HandLeader(MouseHand hand, std::unique_ptr<scene::InputAssist> assist)
    : hand_(std::move(hand)), assist_(std::move(assist)) {}

HandLeader::~HandLeader() {
  done_ = true;
  if (thread_.joinable()) thread_.join();
}

void HandLeader::start(device::HandDevice& device, const MonotonicClock<GraphicsClock>& clock) {
  thread_ = std::thread([this, &device, clock] { run(device, clock); });
}

void HandLeader::run(device::HandDevice& device, MonotonicClock<GraphicsClock> clock) {
  name_and_pin_thread("palpate-hand", -1);
  sharpen_sleep();
  ask_for_short_turns();
  auto next = clock.now();
  while (!done_) {
    next += kLeadEvery;
    if (const auto now = clock.now(); next < now) next = now;
    clock.sleep_until(next);
    const std::lock_guard lock(mutex_);
    if (leads_) device.move_to(led(clock.now()));
  }
}

void HandLeader::point(const device::Pixel& pixel) {
  const std::lock_guard lock(mutex_);
  hand_.point(pixel);
}

void HandLeader::roll(double notches) {
  const std::lock_guard lock(mutex_);
  hand_.roll(notches);
}

void HandLeader::hold_buttons(bool left, bool right) {
  const std::lock_guard lock(mutex_);
  left_ = left, right_ = right;
  hand_.hold_buttons(left, right);
}

void HandLeader::look_through(const device::CameraModel& camera,
                              const Pose<World, CameraOptical>& X_world_camera) {
  const std::lock_guard lock(mutex_);
  hand_.look_through(camera);
  hand_.see(X_world_camera);
  eye_ = X_world_camera.translation;
}

void HandLeader::show(const scene::SceneState& state) {
  const std::lock_guard lock(mutex_);
  if (assist_) assist_->show(state);
}

void HandLeader::synchronised(const ClockModel<GraphicsClock, PhysicsClock>& physics_time) {
  const std::lock_guard lock(mutex_);
  physics_time_ = physics_time;
}

bool HandLeader::turn_head_still() {
  const std::lock_guard lock(mutex_);
  head_still_ = !head_still_;
  return head_still_;
}

std::optional<bool> HandLeader::turn_help() {
  const std::lock_guard lock(mutex_);
  if (!assist_) return std::nullopt;
  helped_ = !helped_;
  return helped_;
}

void HandLeader::take_over(const std::optional<device::HandTarget>& at, Instant<GraphicsClock> now) {
  const std::lock_guard lock(mutex_);
  leads_ = true;
  if (at) hand_.take_over(*at, now.seconds());
}

device::HandTarget HandLeader::let_go(Instant<GraphicsClock> now) {
  const std::lock_guard lock(mutex_);
  leads_ = false;
  return led(now);
}

device::HandTarget HandLeader::step(Instant<GraphicsClock> now) {
  const std::lock_guard lock(mutex_);
  return led(now);
}

device::HandTarget HandLeader::led(Instant<GraphicsClock> now) {
  device::HandTarget target = led_by_hand_or_stroke(now);
  target.head_still = head_still_;
  return target;
}

// Where the person leads the hand, or the stroke that helps them.
device::HandTarget HandLeader::led_by_hand_or_stroke(Instant<GraphicsClock> now) {
  const double t = now.seconds();
  const device::HandTarget target = hand_.act(t);
  if (!assist_ || !helped_ || !eye_ || !physics_time_) return target;
  const double side = (right_ ? 1.0 : 0.0) - (left_ ? 1.0 : 0.0);
  const auto stroke = assist_->act(physics_time_->to(now), {target, *eye_, hand_.ray(), side});
  if (!stroke) return target;
  hand_.take_over(*stroke, t);
  return *stroke;
}

}  // namespace palpate::desktop
