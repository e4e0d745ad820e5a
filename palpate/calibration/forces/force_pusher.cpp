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
      kinematics_(device::make_kinematics(calibration_.model)),
      nominal_(device::make_kinematics(rig.nominal_arm)),
      motors_(arm.motors()),
      torque_limits_(motors_ == nullptr ? device::JointVector() : motors_->limits()),
      limits_(limits),
      clamp_(clamp_limits(limits), kPeriod),
      J_(kinematics_->jacobian(device::JointVector::filled(kinematics_->joint_count(), 0.0))) {
  if (nominal_->joint_count() != kinematics_->joint_count() ||
      (motors_ != nullptr && torque_limits_.size() != kinematics_->joint_count()))
    throw std::invalid_argument("force check: the arm and its calibration differ in their number of joints");
  // No torques until there was a pose that has some.
  device_.J = device::TipJacobian::Zero(3, kinematics_->joint_count());
}

ForcePusher::~ForcePusher() {
  try {
    command(Vector3::Zero());
  } catch (...) {  // a driver that throws has nothing to command any more
  }
  arm_.let_go();
}

void ForcePusher::command(const Vector3& force) {
  if (motors_ != nullptr)
    motors_->command(device_.torques(force, torque_limits_));
  else
    arm_.command(force);
}

// What the reading alone says. Comparisons are written so that a NaN is no good.
BreakOff ForcePusher::look(Instant<PhysicsClock> now, const device::ArmSample& sample) {
  const double since_tick = begun_ ? to_seconds(now - last_tick_) : 0.0;
  last_tick_ = now;
  begun_ = true;
  if (!sample.connected) return BreakOff::arm_lost;
  if (sample.joints.size() != kinematics_->joint_count()) return BreakOff::bad_reading;
  const device::JointVector theta = calibration_.correction.apply(sample.joints);
  if (!theta.allFinite()) return BreakOff::bad_reading;
  buttons_ = sample.buttons;
  if (!sampled_ || sample.stamp != last_stamp_) {
    const Instant<PhysicsClock> measured = now - sample.waited;
    const double dt = sampled_ ? to_seconds(measured - last_fresh_) : kPeriod;
    const auto [X_base_tip, J] = kinematics_->pose_and_jacobian(theta, Vector3::Zero());
    tip_ = X_base_tip.translation;
    J_ = J;
    filter_.update({Quaternion::Identity(), tip_}, dt > 0.0 ? dt : kPeriod);
    velocity_ = filter_.velocity();
    if (!sampled_) start_ = tip_;
    last_fresh_ = measured;
    last_stamp_ = sample.stamp;
    sampled_ = true;
  }
  const auto device = motors_ == nullptr
                          ? haptics::DeviceForce::at(sample.joints, *nominal_, J_, *kinematics_)
                          : haptics::DeviceForce::through_motors(J_, *kinematics_, torque_limits_);
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
      command(clamp_.pass(device_.M * force));
      return reason;
    }
    command(Vector3::Zero());
  } catch (...) {  // a driver that throws has lost its arm
    reason = BreakOff::arm_lost;
  }
  arm_.let_go();
  clamp_.let_go(0.0);
  return reason;
}

}  // namespace palpate::calibration::forces
