#include "palpate/haptics/haptic_loop.h"

#include <fmt/format.h>

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

namespace palpate {
namespace {

HapticSettings checked(const HapticSettings& settings) {
  if (settings.period <= Duration(0)) throw std::invalid_argument("haptic loop: the period must be > 0");
  if (!(settings.force_gain >= 0.0 && settings.force_gain <= 1.0))
    throw std::invalid_argument(
        fmt::format("haptic loop: force_gain is {}, expected 0 ... 1", settings.force_gain));
  if (!(settings.record_s >= 0.0))
    throw std::invalid_argument(fmt::format("haptic loop: record_s is {}, expected >= 0", settings.record_s));
  check_force_limits(settings.limits);
  return settings;
}

}  // namespace

HapticLoop::HapticLoop(ArmDevice& arm, const ArmCalibration& calibration, const PhantomLengths& nominal,
                       const HapticSettings& settings, TripleBuffer<HapticInput>& input,
                       TripleBuffer<TipState>& output)
    : arm_(arm),
      calibration_(calibration),
      nominal_(nominal),
      settings_(checked(settings)),
      period_(to_seconds(settings.period)),
      input_(input),
      output_(output),
      filter_(std::pow(0.6, period_ / 1e-3), std::pow(0.8, period_ / 1e-3)),  // the same lag at any rate
      passivity_(settings.limits.most_damping_n_s_m),
      guard_(settings.limits),
      shaper_(settings.limits.longest_debt_s),
      heat_(settings.limits),
      clamp_(settings.limits, period_),
      records_(std::make_unique<HapticRecords>()) {}

void HapticLoop::tick(Instant<PhysicsClock> now) {
  VitalSigns signs;
  const double elapsed = started_ ? std::max(0.0, to_seconds(now - last_tick_)) : 0.0;
  last_tick_ = now;
  started_ = true;
  signs.elapsed_s = elapsed;
  signs.clamp_good = !clamp_.tripped();
  const DeviceForce device_before = device_;
  read_arm(now, signs);
  listen(now, signs);
  AskedForce asked = asked_force(now);
  signs.asked_good = asked.good();
  if (!signs.asked_good) asked = AskedForce{};
  heat_.held(clamp_.last().norm(), elapsed);
  signs.warm = heat_.warm();

  const ForceFault before = guard_.fault();
  const double gain_before = guard_.gain();
  guard_.tick(signs, period_);

  // The device's force is M f. That it stays within the device's limits while M changes is the shaper's room.
  const Quaternion R_base_world = calibration_.X_world_base.rotation.conjugate();
  const double turned = ((device_.M - device_before.M) * (R_base_world * shaper_.held())).norm();
  const ForceRoom room{.peak = heat_.allowed_n() / std::max(1.0, device_.gain),
                       .step = (settings_.limits.slew_n_s * period_ - turned) / std::max(1.0, device_.gain),
                       .gain = guard_.gain(),
                       .fading = guard_.fault() != ForceFault::none,
                       .forgive = elapsed > settings_.limits.stale_s};
  const bool touching = asked.sustained != Vector3::Zero() || shaper_.sustained() != Vector3::Zero();
  passivity_.moved(shaper_.sustained(), moved_, touching);
  AskedForce damped = asked;
  if (touching) damped.sustained += passivity_.damping(tip_.velocity, period_);
  const Vector3 force = shaper_.tick(damped, room, elapsed, period_);
  arm_.command(clamp_.pass(device_.M * (R_base_world * force)));
  if (signs.reading_good) output_.write(tip_);

  account(elapsed);
  keep(now, asked, before, gain_before);
}

// Where the reading makes no sense the last good tip stays, and the last way from force to device.
void HapticLoop::read_arm(Instant<PhysicsClock> now, VitalSigns& signs) {
  const ArmSample sample = arm_.read();
  const Vector3 theta = calibration_.correction.apply(sample.joints);
  signs.connected = sample.connected;
  signs.reading_good = theta.allFinite() && sample.gimbal.allFinite();
  if (!sampled_ || sample.stamp != last_stamp_) last_fresh_sample_ = now;
  last_stamp_ = sample.stamp;
  joints_ = sample.joints;
  note_withheld(sample.withheld);
  moved_.setZero();
  if (signs.reading_good) {
    const Vector3 gimbal = calibration_.gimbal_gain.cwiseProduct(sample.gimbal) + calibration_.gimbal_offset;
    const Vector3 place = tip_.X_world_tip.translation;
    tip_.time = now - sample.waited;
    tip_.X_world_tip = calibration_.X_world_base * phantom_pose(theta, gimbal, calibration_.lengths);
    if (sampled_) moved_ = tip_.X_world_tip.translation - place;
    const double since = sampled_ ? to_seconds(now - last_sample_) : 0.0;
    if (!sampled_ || since > 0.0) filter_.update(tip_.X_world_tip, since);
    tip_.velocity = filter_.velocity();
    tip_.angular_velocity = filter_.angular_velocity();
    last_sample_ = now;
    sampled_ = true;
    const auto device = DeviceForce::at(sample.joints, nominal_, theta, calibration_.lengths);
    if (device) device_ = *device;
    signs.inside_workspace = device.has_value();
    for (int i = 0; i < 3; ++i) {
      const auto& [low, high] = settings_.limits.joint_range[static_cast<std::size_t>(i)];
      signs.inside_workspace = signs.inside_workspace && theta[i] >= low && theta[i] <= high;
    }
  } else {
    ++statistics_.bad_samples;
  }
  signs.tip_speed = tip_.velocity.norm();
  signs.reading_age_s =
      sampled_ ? to_seconds(now - last_fresh_sample_) : std::numeric_limits<double>::infinity();
}

// Counts for the blows on their way, all of it: what else was held then is not told apart.
void HapticLoop::note_withheld(const Vector3& withheld) {
  if (!withheld.allFinite()) return;
  const Vector3 change = withheld - device_withheld_;
  device_withheld_ = withheld;
  if (player_.asked() == asked_before_) return;
  const Vector3 felt = device_.M.partialPivLu().solve(change);
  withheld_ += calibration_.X_world_base.rotation * felt;
}

void HapticLoop::listen(Instant<PhysicsClock> now, VitalSigns& signs) {
  HapticInput said;
  if (input_.read(said) && (!heard_ || said.time > newest_.time)) {
    const std::uint64_t before = newest_.contact.number;
    const bool first = !heard_;
    newest_ = said;
    heard_ = true;
    last_heard_ = now;
    // What went before the first word is nobody's to feel.
    begin_blows(first && said.contact.number != 0 ? said.contact.number - 1 : before, now);
  }
  signs.input_age_s = heard_ ? to_seconds(now - last_heard_) : std::numeric_limits<double>::infinity();
}

// Those of the newest input that are newer than number `after`, oldest first.
void HapticLoop::begin_blows(std::uint64_t after, Instant<PhysicsClock> now) {
  const auto begin = [&](const ContactEvent& blow) {
    ++(player_.start(blow, now) ? statistics_.blows : statistics_.rejected_blows);
  };
  const ContactEvent& newest = newest_.contact;
  if (newest.number == after || newest.number == 0) return;
  std::uint64_t seen = after;
  const auto missed = [&](std::uint64_t number) {
    if (number > seen + 1) statistics_.missed_blows += number - seen - 1;
    seen = number;
  };
  for (auto blow = newest_.earlier.rbegin(); blow != newest_.earlier.rend(); ++blow) {
    if (blow->number <= seen || blow->number >= newest.number) continue;
    missed(blow->number);
    begin(*blow);
  }
  missed(newest.number);
  begin(newest);
}

AskedForce HapticLoop::asked_force(Instant<PhysicsClock> now) {
  AskedForce asked;
  asked.sustained = settings_.force_gain * newest_.sustained;
  asked.blow = settings_.force_gain * player_.tick(now, settings_.period);
  asked.blow_active = player_.active();
  asked.blow_to_come = settings_.force_gain * player_.to_come();
  return asked;
}

// Compares what was asked with what was given each time the hand has come to rest between blows, and the
// device has had time to tell what it made of the last force.
void HapticLoop::account(double elapsed) {
  settled_s_ = player_.active() || !shaper_.settled() ? 0.0 : settled_s_ + elapsed;
  constexpr double kDeviceTells = 0.005;  // s
  if (settled_s_ < kDeviceTells || player_.asked() == asked_before_) return;
  const Vector3 asked = settings_.force_gain * (player_.asked() - asked_before_);
  const double missing = (asked - (shaper_.delivered() - delivered_before_ - withheld_)).norm();
  statistics_.impulse_asked += asked.norm();
  statistics_.impulse_lost += missing;
  if (asked.norm() > 0.0) {
    statistics_.impulse_error_rel_max = std::max(statistics_.impulse_error_rel_max, missing / asked.norm());
  }
  asked_before_ = player_.asked();
  withheld_.setZero();
  delivered_before_ = shaper_.delivered();
}

void HapticLoop::keep(Instant<PhysicsClock> now, const AskedForce& asked, ForceFault before,
                      double gain_before) {
  const ForceFault fault = guard_.fault();
  statistics_.peak_n = std::max(statistics_.peak_n, clamp_.last().norm());
  ++statistics_.ticks;
  statistics_.limited_ticks += shaper_.limited() || clamp_.tripped();
  statistics_.peak_limited_ticks += shaper_.limited() && shaper_.at_peak();
  statistics_.fault_ticks += fault != ForceFault::none;
  statistics_.damped_ticks += passivity_.injected() > 0.0;
  statistics_.warm_ticks += heat_.warm();
  records_->push({now, joints_, tip_.X_world_tip.translation, asked.sustained + asked.blow, clamp_.last(),
                  fault, guard_.state(), tip_.velocity.norm()});

  const bool became_safe = guard_.state() == HapticState::safe && told_.state != HapticState::safe;
  const bool forces_taken = fault != ForceFault::none && before == ForceFault::none && gain_before > 0.0;
  told_.state = guard_.state();
  told_.fault = fault;
  told_.ticks = statistics_.ticks;
  if (became_safe || forces_taken) {
    ++told_.trips;
    told_.trip_tick = statistics_.ticks;
    told_.trip_fault = fault;
  }
  condition_.write(told_);
}

std::vector<HapticRecord> HapticLoop::records_before(std::uint64_t tick) const {
  const std::uint64_t end = std::min(tick, records_->count());
  const auto wanted = static_cast<std::uint64_t>(
      std::min(std::max(1.0, settings_.record_s / period_), static_cast<double>(HapticRecords::capacity())));
  std::vector<HapticRecord> list;
  list.reserve(std::min(wanted, end));
  for (std::uint64_t i = end - std::min(wanted, end); i < end; ++i)
    if (const auto record = records_->read(i)) list.push_back(*record);
  return list;
}

}  // namespace palpate
