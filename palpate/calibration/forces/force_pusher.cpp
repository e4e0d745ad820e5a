#include "palpate/calibration/forces/force_pusher.h"

#include <stdexcept>

namespace palpate::calibration::forces {
namespace {

haptics::ForceLimits clamp_limits(const PushLimits& limits) {
  haptics::ForceLimits clamp;
  clamp.peak_n = limits.peak_n;
  clamp.slew_n_s = limits.slew_n_s;
  return clamp;
}

const rig::ArmCalibration& arm_of(const rig::Rig& rig) {
  if (!rig.arm)
    throw std::invalid_argument("force check: the rig has no arm calibration; run `palpate calibrate arm`");
  return *rig.arm;
}

constexpr double kPeriod = 0.001;  // s

}  // namespace

std::string_view name_of(BreakOff reason) {
  switch (reason) {
    case BreakOff::none:
      return "none";
    case BreakOff::key_released:
      return "key released";
    case BreakOff::too_far:
      return "too far";
    case BreakOff::too_fast:
      return "too fast";
    case BreakOff::arm_silent:
      return "arm silent";
    case BreakOff::arm_lost:
      return "arm lost";
    case BreakOff::bad_reading:
      return "bad reading";
    case BreakOff::outside_workspace:
      return "outside workspace";
    case BreakOff::late_tick:
      return "late tick";
  }
  return "unknown";
}

ForcePusher::ForcePusher(device::ArmDevice& arm, const rig::Rig& rig, const PushLimits& limits)
    : arm_(arm),
      calibration_(arm_of(rig)),
      nominal_(rig.nominal_lengths),
      limits_(limits),
      clamp_(clamp_limits(limits), kPeriod) {}

ForcePusher::~ForcePusher() {
  try {
    arm_.command(Vector3::Zero());
  } catch (...) {  // a driver that throws has nothing to command any more
  }
  arm_.let_go();
}

Matrix3 ForcePusher::jacobian() const { return device::phantom_jacobian(theta_, calibration_.lengths); }

// What the reading alone says. Comparisons are written so that a NaN is no good.
BreakOff ForcePusher::look(Instant<PhysicsClock> now, const device::ArmSample& sample) {
  const double since_tick = begun_ ? to_seconds(now - last_tick_) : 0.0;
  last_tick_ = now;
  begun_ = true;
  if (!sample.connected) return BreakOff::arm_lost;
  const Vector3 theta = calibration_.correction.apply(sample.joints);
  if (!theta.allFinite()) return BreakOff::bad_reading;
  buttons_ = sample.buttons;
  if (!sampled_ || sample.stamp != last_stamp_) {
    const Instant<PhysicsClock> measured = now - sample.waited;
    const double dt = sampled_ ? to_seconds(measured - last_fresh_) : kPeriod;
    theta_ = theta;
    tip_ = device::phantom_tip(theta, calibration_.lengths).m;
    filter_.update({Quaternion::Identity(), tip_}, dt > 0.0 ? dt : kPeriod);
    velocity_ = filter_.velocity();
    if (!sampled_) start_ = tip_;
    last_fresh_ = measured;
    last_stamp_ = sample.stamp;
    sampled_ = true;
  }
  const auto device = haptics::DeviceForce::at(sample.joints, nominal_, theta_, calibration_.lengths);
  if (device) device_ = *device;
  if (!(since_tick < limits_.stale_s)) return BreakOff::late_tick;
  if (!(to_seconds(now - last_fresh_) < limits_.stale_s)) return BreakOff::arm_silent;
  return device ? BreakOff::none : BreakOff::outside_workspace;
}

BreakOff ForcePusher::tick(Instant<PhysicsClock> now, const Vector3& force, bool key_held) {
  BreakOff reason = BreakOff::arm_lost;
  try {
    reason = look(now, arm_.read());
    const bool pushes = force != Vector3::Zero() || clamp_.last() != Vector3::Zero();
    if (reason == BreakOff::none && pushes) {
      if (!key_held) reason = BreakOff::key_released;
      if (!(velocity_.norm() <= limits_.most_speed_m_s)) reason = BreakOff::too_fast;
      if (!(way().norm() <= limits_.most_way_m)) reason = BreakOff::too_far;
    }
    if (reason == BreakOff::none) {
      arm_.command(clamp_.pass(device_.M * force));
      return reason;
    }
    arm_.command(Vector3::Zero());
  } catch (...) {  // a driver that throws has lost its arm
    reason = BreakOff::arm_lost;
  }
  arm_.let_go();
  clamp_.let_go(0.0);
  return reason;
}

}  // namespace palpate::calibration::forces
