#include "palpate/haptics/force_guard.h"

#include <algorithm>

namespace palpate::haptics {

ForceGuard::ForceGuard(const ForceLimits& limits, bool permitted, bool armed)
    : limits_(limits),
      permitted_(permitted),
      state_(permitted && armed ? ForceState::ready : ForceState::safe),
      fault_(!permitted ? ForceFault::arm_unchecked
             : armed    ? ForceFault::none
                        : ForceFault::not_armed),
      present_(permitted ? ForceFault::none : fault_),
      strength_({.stale_s = limits.stale_s, .fade_s = limits.fade_s, .ramp_s = limits.start_ramp_s}) {}

// Comparisons are written so that a NaN counts as a fault.
ForceFault ForceGuard::lasting_fault(const SafetyInputs& inputs) const {
  if (!inputs.connected) return ForceFault::arm_lost;
  if (!inputs.clamp_good) return ForceFault::clamp_tripped;
  if (!inputs.law_good) return ForceFault::law_failed;
  if (!inputs.arm_quick) return ForceFault::arm_slow;
  if (!permitted_) return ForceFault::arm_unchecked;
  if (inputs.reading_good && !(inputs.tip_speed <= limits_.max_tip_speed_m_s)) return ForceFault::overspeed;
  return ForceFault::none;
}

ForceFault ForceGuard::healing_fault(const SafetyInputs& inputs) const {
  if (!inputs.reading_good) return ForceFault::bad_reading;
  if (!inputs.requested_good) return ForceFault::bad_force;
  if (!(inputs.reading_age_s < limits_.stale_s)) return ForceFault::arm_silent;
  if (!(inputs.input_age_s < limits_.stale_s)) return ForceFault::stale_input;
  if (!inputs.inside_workspace) return ForceFault::outside_workspace;
  if (!inputs.button_held) return ForceFault::button_released;
  return ForceFault::none;
}

void ForceGuard::tick(const SafetyInputs& inputs) {
  present_ = lasting_fault(inputs);
  const ForceFault missing = healing_fault(inputs);
  // A late tick is told as one, also where all it sees is good: forces then go on from what is held.
  const bool late = !(inputs.elapsed_s < limits_.stale_s);
  const ForceFault healing = late && missing != ForceFault::bad_reading && missing != ForceFault::bad_force
                                 ? ForceFault::late_tick
                                 : missing;
  // An overspeed ends by itself (PhysicsServer re-arms when the tip has calmed down); what else lasts, and comes while
  // forces are off for it, does not.
  if (state_ == ForceState::safe && fault_ == ForceFault::overspeed && present_ != ForceFault::none)
    fault_ = present_;
  if (state_ != ForceState::safe) {
    if (present_ != ForceFault::none) {
      state_ = ForceState::safe;
      fault_ = present_;
    } else if (healing != ForceFault::none) {
      // Before everything has been heard of once, nothing has failed yet.
      if (state_ != ForceState::ready) state_ = ForceState::degraded, fault_ = healing;
    } else {
      state_ = inputs.warm ? ForceState::degraded : ForceState::running;
      fault_ = ForceFault::none;
    }
  }
  const bool good = state_ != ForceState::safe && missing == ForceFault::none;
  strength_.tick(good, std::max(inputs.input_age_s, inputs.reading_age_s), inputs.elapsed_s, inputs.held);
}

bool ForceGuard::rearm() {
  if (state_ != ForceState::safe || present_ != ForceFault::none) return false;
  state_ = ForceState::ready;
  fault_ = ForceFault::none;
  strength_.restart();
  return true;
}

}  // namespace palpate::haptics
