#include "palpate/haptics/force_guard.h"

#include <fmt/format.h>

#include <algorithm>

namespace palpate {

std::string_view name_of(HapticState state) {
  switch (state) {
    case HapticState::ready:
      return "ready";
    case HapticState::running:
      return "running";
    case HapticState::degraded:
      return "degraded";
    case HapticState::safe:
      return "safe";
  }
  return "unknown";
}

std::string_view name_of(ForceFault fault) {
  switch (fault) {
    case ForceFault::none:
      return "none";
    case ForceFault::stale_input:
      return "stale input";
    case ForceFault::not_finite:
      return "force not finite";
    case ForceFault::bad_reading:
      return "bad reading";
    case ForceFault::arm_silent:
      return "arm silent";
    case ForceFault::outside_workspace:
      return "outside workspace";
    case ForceFault::late_tick:
      return "late tick";
    case ForceFault::overspeed:
      return "overspeed";
    case ForceFault::arm_lost:
      return "arm lost";
    case ForceFault::clamp_tripped:
      return "clamp tripped";
  }
  return "unknown";
}

std::string condition_text(HapticState state, ForceFault fault) {
  if (fault != ForceFault::none) return fmt::format("{}: {}", name_of(state), name_of(fault));
  return std::string(name_of(state)) + (state == HapticState::degraded ? ": motors warm" : "");
}

// Comparisons are written so that a NaN counts as a fault.
ForceFault ForceGuard::lasting_fault(const VitalSigns& signs) const {
  if (!signs.connected) return ForceFault::arm_lost;
  if (!signs.clamp_good) return ForceFault::clamp_tripped;
  if (signs.reading_good && !(signs.tip_speed <= limits_.max_tip_speed_m_s)) return ForceFault::overspeed;
  return ForceFault::none;
}

ForceFault ForceGuard::healing_fault(const VitalSigns& signs) const {
  if (!signs.reading_good) return ForceFault::bad_reading;
  if (!signs.asked_good) return ForceFault::not_finite;
  if (!(signs.elapsed_s < limits_.stale_s)) return ForceFault::late_tick;
  if (!(signs.reading_age_s < limits_.stale_s)) return ForceFault::arm_silent;
  if (!(signs.input_age_s < limits_.stale_s)) return ForceFault::stale_input;
  if (!signs.inside_workspace) return ForceFault::outside_workspace;
  return ForceFault::none;
}

void ForceGuard::tick(const VitalSigns& signs, double period) {
  present_ = lasting_fault(signs);
  const ForceFault healing = healing_fault(signs);
  if (state_ != HapticState::safe) {
    if (present_ != ForceFault::none) {
      state_ = HapticState::safe;
      fault_ = present_;
    } else if (healing != ForceFault::none) {
      // Before everything has been heard of once, nothing has failed yet.
      if (state_ != HapticState::ready) state_ = HapticState::degraded, fault_ = healing;
    } else {
      state_ = signs.warm ? HapticState::degraded : HapticState::running;
      fault_ = ForceFault::none;
    }
  }
  const bool good = state_ != HapticState::safe && healing == ForceFault::none;
  if (good) {
    gain_ = limits_.start_ramp_s > 0.0 ? std::min(1.0, gain_ + period / limits_.start_ramp_s) : 1.0;
  } else {
    gain_ = std::max(0.0, gain_ - period / limits_.fade_s);
    if (gain_ < 1e-12) gain_ = 0.0;  // what rounding leaves of n steps of 1/n
  }
}

bool ForceGuard::rearm() {
  if (state_ != HapticState::safe || present_ != ForceFault::none) return false;
  state_ = HapticState::ready;
  fault_ = ForceFault::none;
  return true;
}

}  // namespace palpate
