#include "palpate/haptics/haptic_loop.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

namespace palpate {
namespace {

// A force at the peak may grow by a few percent when it is turned into the device's nominal axes; that much
// is kept free, so that nothing is cut after the impulse has been counted.
ForceLimits inner_limits(ForceLimits limits) {
  limits.peak_n *= 0.95;
  return limits;
}

}  // namespace

HapticLoop::HapticLoop(ArmDevice& arm, const ArmCalibration& calibration, const PhantomLengths& nominal,
                       const HapticSettings& settings, TripleBuffer<HapticInput>& input,
                       TripleBuffer<TipState>& output)
    : arm_(arm),
      calibration_(calibration),
      nominal_(nominal),
      settings_(settings),
      input_(input),
      output_(output),
      limiter_(inner_limits(settings.limits)) {
  if (settings.period <= Duration(0)) throw std::invalid_argument("haptic loop: the period must be > 0");
  ring_.resize(static_cast<std::size_t>(std::max(1.0, settings.record_s / to_seconds(settings.period))));
}

void HapticLoop::tick(Instant<PhysicsClock> now) {
  const double period = to_seconds(settings_.period);
  const double elapsed = started_ ? to_seconds(now - last_tick_) : 0.0;
  last_tick_ = now;

  const ArmSample sample = arm_.read();
  const Vector3 theta = calibration_.correction.apply(sample.joints);
  const bool usable = theta.allFinite() && sample.gimbal.allFinite();
  if (usable) {
    joints_ = sample.joints;
    theta_ = theta;
    const Vector3 gimbal = calibration_.gimbal_gain.cwiseProduct(sample.gimbal) + calibration_.gimbal_offset;
    tip_.time = now;
    tip_.X_world_tip = calibration_.X_world_base * phantom_pose(theta, gimbal, calibration_.lengths);
    const double since = sampled_ ? to_seconds(now - last_sample_) : 0.0;
    if (!sampled_ || since > 0.0) filter_.update(tip_.X_world_tip, since);
    tip_.velocity = filter_.velocity();
    tip_.angular_velocity = filter_.angular_velocity();
    sampled_ = true;
    last_sample_ = now;
  } else {
    ++statistics_.bad_samples;  // the last good tip stays published; the force fades below
  }

  listen(now);
  AskedForce asked;
  asked.sustained = newest_.sustained;
  asked.blow = player_.tick(now, settings_.period);
  asked.blow_active = player_.active();
  asked.blow_to_come = player_.to_come();
  asked.tip_speed = usable ? tip_.velocity.norm() : std::nan("");
  asked.input_age_s = heard_ ? to_seconds(now - last_heard_) : std::numeric_limits<double>::infinity();
  const Vector3 force = limiter_.tick(asked, elapsed, period);
  const Vector3 command = sampled_ ? device_force(force) : Vector3::Zero();
  arm_.command(command);
  if (usable) output_.write(tip_);

  account();
  statistics_.peak_n = std::max(statistics_.peak_n, command.norm());
  ring_[statistics_.ticks % ring_.size()] = {
      now,     sample.joints,   tip_.X_world_tip.translation, asked.sustained + asked.blow,
      command, limiter_.fault()};
  ++statistics_.ticks;
  statistics_.limited_ticks += limiter_.limited();
  statistics_.fault_ticks += limiter_.fault() != ForceFault::none;
  started_ = true;
}

void HapticLoop::listen(Instant<PhysicsClock> now) {
  const std::uint64_t before = newest_.contact.number;
  if (!input_.read(newest_)) return;
  heard_ = true;
  last_heard_ = now;
  if (newest_.contact.number == before || newest_.contact.number == 0) return;
  if (player_.start(newest_.contact, now)) {
    ++statistics_.blows;
  } else {
    ++statistics_.rejected_blows;
  }
}

// Compares what was asked with what was given each time the hand has come to rest between blows.
void HapticLoop::account() {
  if (player_.active() || !limiter_.settled() || player_.asked() == asked_before_) return;
  const Vector3 asked = player_.asked() - asked_before_;
  const double missing = (asked - (limiter_.delivered() - delivered_before_)).norm();
  statistics_.impulse_asked += asked.norm();
  statistics_.impulse_lost += missing;
  if (asked.norm() > 0.0) {
    statistics_.impulse_error_rel_max = std::max(statistics_.impulse_error_rel_max, missing / asked.norm());
  }
  asked_before_ = player_.asked();
  delivered_before_ = limiter_.delivered();
}

// The device turns a force into motor torques by its own nominal kinematics at its own uncorrected angles. To
// have the true force at the tip, ask for the one whose torques are right: Jn(psi)^T f_device = J(theta)^T f.
Vector3 HapticLoop::device_force(const Vector3& world) const {
  const Vector3 base = calibration_.X_world_base.rotation.conjugate() * world;
  const Matrix3 nominal = phantom_jacobian(joints_, nominal_).transpose();
  constexpr double kLeastDeterminant = 1e-4;  // m^3; a folded arm has no force in some direction
  if (std::abs(nominal.determinant()) < kLeastDeterminant) return base;
  Vector3 device = nominal.inverse() * (phantom_jacobian(theta_, calibration_.lengths).transpose() * base);
  const double norm = device.norm();
  if (!std::isfinite(norm)) return Vector3::Zero();
  if (norm > settings_.limits.peak_n) device *= settings_.limits.peak_n / norm;
  return device;
}

std::vector<HapticRecord> HapticLoop::records() const {
  const std::size_t count = std::min<std::size_t>(statistics_.ticks, ring_.size());
  std::vector<HapticRecord> list;
  list.reserve(count);
  for (std::size_t i = statistics_.ticks - count; i < statistics_.ticks; ++i)
    list.push_back(ring_[i % ring_.size()]);
  return list;
}

}  // namespace palpate
