#include "drivers/arms/loop_mailbox.h"

#include <algorithm>
#include <limits>

namespace palpate::drivers::arms {
namespace {

Vector3 vector(const std::array<double, 3>& v) { return {v[0], v[1], v[2]}; }
std::array<double, 3> list(const Vector3& v) { return {v.x(), v.y(), v.z()}; }

}  // namespace

device::ArmSample LoopMailbox::read() const {
  device::ArmSample sample;
  Reading reading;
  const bool any = readings_.read(reading);
  const std::int64_t now = now_ns();
  const bool lost = is_lost();
  sample.stamp = {Duration(any ? reading.stamp_ns : now)};
  const bool fresh = any && !lost && reading.stamp_ns >= started_ns_.load(std::memory_order_relaxed) &&
                     seconds_between(reading.stamp_ns, now) <= settings_.watchdog_s;
  if (fresh) {
    sample.joints = {reading.joints[0], reading.joints[1], reading.joints[2]};
    sample.gimbal = vector(reading.gimbal);
    sample.buttons = reading.buttons;
  } else {
    sample.joints.setConstant(std::numeric_limits<double>::quiet_NaN());
    sample.gimbal.setConstant(std::numeric_limits<double>::quiet_NaN());
  }
  sample.waited = std::max(Duration(0), Duration(now - sample.stamp.ns()));
  sample.connected = !lost;
  std::optional<HeldWire> held;
  if (HeldWire wire; held_box_.read(wire)) held = wire;
  sample.withheld = withheld(held, sample.connected);
  if (lost || !held)
    sample.held = Vector3::Zero();
  else if (held->known != 0)
    sample.held = vector(held->force);
  return sample;
}

// Both impulses are carried on to now, so that a force that is held adds nothing to the difference. Of a
// device that is gone nothing more is known to be given.
Vector3 LoopMailbox::withheld(const std::optional<HeldWire>& held, bool connected) const {
  if (commanded_ns_ == 0) return Vector3::Zero();
  const std::int64_t now = now_ns();
  Vector3 given = Vector3::Zero();
  if (held) {
    given = vector(held->impulse);
    if (connected) given += seconds_between(held->stamp_ns, now) * vector(held->force);
  }
  return commanded_impulse_ + seconds_between(commanded_ns_, now) * commanded_ - given;
}

void LoopMailbox::command(const Vector3& force) {
  const bool usable = force.allFinite();
  if (!usable) refused_commands_.fetch_add(1, std::memory_order_relaxed);
  const Vector3 kept = usable ? force : Vector3(Vector3::Zero());
  const std::int64_t now = now_ns();
  if (commanded_ns_ != 0) commanded_impulse_ += seconds_between(commanded_ns_, now) * commanded_;
  commanded_ = kept;
  commanded_ns_ = now;
  commands_.write({now, list(kept)});
}

void LoopMailbox::start(std::int64_t now) {
  strength_.restart();
  held_.setZero();
  last_force_ns_ = last_held_ns_ = 0;
  started_ns_.store(now);
}

void LoopMailbox::put(const Reading& reading) { readings_.write(reading); }

Vector3 LoopMailbox::force_now(std::int64_t now, bool allowed, std::optional<std::int64_t> sampled_ns) {
  const double elapsed = last_force_ns_ == 0 ? 0.0 : seconds_between(last_force_ns_, now);
  last_force_ns_ = now;
  if (sampled_ns) last_sampled_ns_ = *sampled_ns;
  CommandWire wire;
  const bool any = commands_.read(wire);
  const double command_age = any ? seconds_between(wire.sent_ns, now) : 0.0;
  const bool stale = any && command_age > settings_.watchdog_s;
  if (stale) stale_forces_.fetch_add(1, std::memory_order_relaxed);
  if (!any || !allowed) {
    strength_.restart();
    return Vector3::Zero();
  }
  const double sample_age = seconds_between(last_sampled_ns_, now);
  const bool sampled = sampled_ns && sample_age <= settings_.watchdog_s;
  const bool released = wire.sent_ns <= let_go_ns_.load();
  strength_.tick(!stale && !released && sampled, std::max(command_age, sample_age), elapsed);
  if (!sampled_ns || released) strength_.let_go();
  return strength_.gain() * vector(wire.force);
}

void LoopMailbox::tell_held(std::int64_t now, const Vector3& asked, const std::optional<Vector3>& held) {
  if (last_held_ns_ != 0) held_impulse_ += seconds_between(last_held_ns_, now) * held_;
  last_held_ns_ = now;
  held_ = held.value_or(asked);
  held_box_.write({now, list(held_impulse_), list(held_), held ? 1u : 0u});
}

}  // namespace palpate::drivers::arms
