#include "palpate/device/force_condition.h"

namespace palpate::device {

std::string_view name_of(ForceState state) {
  switch (state) {
    case ForceState::ready:
      return "ready";
    case ForceState::running:
      return "running";
    case ForceState::degraded:
      return "degraded";
    case ForceState::safe:
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
    case ForceFault::bad_force:
      return "force beyond reason";
    case ForceFault::bad_reading:
      return "bad reading";
    case ForceFault::arm_silent:
      return "arm silent";
    case ForceFault::outside_workspace:
      return "outside workspace";
    case ForceFault::late_tick:
      return "late tick";
    case ForceFault::button_released:
      return "button released";
    case ForceFault::overspeed:
      return "overspeed";
    case ForceFault::arm_lost:
      return "arm lost";
    case ForceFault::clamp_tripped:
      return "clamp tripped";
    case ForceFault::law_failed:
      return "contact law failed";
    case ForceFault::arm_slow:
      return "arm slow";
    case ForceFault::arm_unchecked:
      return "arm not checked";
    case ForceFault::not_armed:
      return "not armed";
  }
  return "unknown";
}

std::string reason_text(const ForceCondition& condition) {
  if (condition.fault != ForceFault::none) return std::string(name_of(condition.fault));
  return condition.state == ForceState::degraded ? "motors warm" : "";
}

std::string condition_text(const ForceCondition& condition) {
  const std::string reason = reason_text(condition);
  return std::string(name_of(condition.state)) + (reason.empty() ? "" : ": " + reason);
}

}  // namespace palpate::device
