// HapticLoop's calls into code of others, the arm's driver and the contact law, and who is to blame.
#include <algorithm>
#include <limits>

#include "palpate/haptics/haptic_loop.h"

namespace palpate::haptics {

// Says who it is that runs, for whoever finds this thread hanging or crashed.
template <typename Call>
void HapticLoop::visit(Guest guest, GuestWatch& watch, Call&& call) {
  busy_with_.store(guest, std::memory_order_relaxed);
  const GuestCall named(guest_words_[static_cast<std::size_t>(guest)].c_str());
  watch.time(std::forward<Call>(call));
  busy_with_.store(Guest::none, std::memory_order_relaxed);
}

// A driver that throws has lost its arm.
device::ArmSample HapticLoop::read_arm() {
  device::ArmSample sample;
  bool threw = arm_threw_;
  arm_threw_ = false;
  try {
    visit(Guest::arm, arm_watch_, [&] {
      const InputTrace::Scope outside(nullptr);  // what the driver learns stands in the sample
      sample = arm_.read();
    });
  } catch (...) {
    threw = true;
  }
  arm_took_ = arm_watch_.took();
  if (!threw) return sample;
  sample.joints =
      device::JointVector::filled(kinematics_->joint_count(), std::numeric_limits<double>::quiet_NaN());
  sample.connected = false;
  return sample;
}

void HapticLoop::command_arm(const Vector3& force) {
  try {
    visit(Guest::arm, arm_watch_, [&] {
      const InputTrace::Scope outside(nullptr);
      if (motors_ != nullptr)
        motors_->command(device_.torques(force, torque_limits_));
      else
        arm_.command(force);
    });
  } catch (...) {
    arm_threw_ = true;
  }
}

// What the law says of the tip just read. What is no force, or lies beyond its promise, is not given.
void HapticLoop::feel_law(Instant<PhysicsClock> now) {
  law_erred_ = false;
  law_force_.setZero();
  law_took_ = Duration(0);
  if (guests_.law == nullptr || law_off_ || !sampled_) return;
  const double since = started_ ? std::max(0.0, to_seconds(now - last_tick_)) : 0.0;
  Vector3 force = Vector3::Zero();
  visit(Guest::contact_law, law_watch_, [&] { force = guests_.law->force(tip_, since); });
  law_took_ = law_watch_.took();
  ++statistics_.law_ticks;
  statistics_.law_overruns = law_watch_.overruns();
  constexpr double kRounding = 1e-9;
  law_erred_ = !(force.norm() <= law_bound_n_ * (1.0 + kRounding));
  statistics_.law_bad_forces += law_erred_;
  if (law_erred_) law_watch_.blame();
  if (const auto due = law_delay_.push(law_erred_ ? Vector3(Vector3::Zero()) : force, now)) law_due_ = *due;
  law_force_ = law_due_;
}

// How long the guests have kept the tick; 0 where that is no more than a tick may take.
Duration HapticLoop::held_up() {
  const Duration arm = arm_took_, law = law_took_;
  slowest_ = Guest::none;
  if (!(to_seconds(arm + law) >= settings_.limits.stale_s)) return Duration(0);
  slowest_ = arm > law ? Guest::arm : Guest::contact_law;
  return arm + law;
}

// Once, in the tick in which it has been too much: the guard keeps it in mind.
void HapticLoop::judge_guests(SafetyInputs& inputs) {
  inputs.law_good = law_off_ || !law_watch_.failed();
  inputs.arm_quick = !arm_watch_.failed();
  if (!inputs.law_good) law_off_ = true;
  if (!inputs.arm_quick) arm_watch_.forgive();
}

Guest HapticLoop::culprit() const {
  switch (guard_.fault()) {
    case ForceFault::stale_input:
      return Guest::application;
    case ForceFault::bad_force:
      return guests_.law != nullptr && (law_erred_ || !law_force_.isZero(0.0)) ? Guest::contact_law
                                                                               : Guest::application;
    case ForceFault::law_failed:
      return Guest::contact_law;
    case ForceFault::bad_reading:
    case ForceFault::arm_silent:
    case ForceFault::arm_lost:
    case ForceFault::arm_slow:
      return slowest_ == Guest::contact_law ? slowest_ : Guest::arm;
    case ForceFault::late_tick:
      return slowest_;
    case ForceFault::none:
    case ForceFault::outside_workspace:
    case ForceFault::button_released:
    case ForceFault::overspeed:
    case ForceFault::clamp_tripped:
    case ForceFault::arm_unchecked:
    case ForceFault::not_armed:
      break;
  }
  return Guest::none;
}

}  // namespace palpate::haptics
