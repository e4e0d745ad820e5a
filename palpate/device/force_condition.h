// How the forces of an arm stand, for whoever decides by it: the haptic loop, a status, a window.
//
// ForceGuard (palpate/haptics/force_guard.h) says what the states mean and how one follows another. Values, any
// thread.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

namespace palpate::device {

enum class ForceState : std::uint8_t { ready, running, degraded, safe };

enum class ForceFault : std::uint8_t {
  none,
  // heal by themselves
  stale_input,        // physics silent, or frozen: its state does not move on
  bad_force,          // a force requested that is no number, or beyond what was promised or reason allows
  bad_reading,        // encoders say something that is no number
  arm_silent,         // the arm's stamps do not move on
  outside_workspace,  // joint range left, or next to a singular pose
  late_tick,          // the loop itself stood still
  button_released,    // the dead-man switch, where the rig wants one
  // do not heal
  overspeed,
  arm_lost,       // the device says that it is gone, or its driver failed
  clamp_tripped,  // the last clamp had to act
  law_failed,     // the contact law was too slow, or asked for bad forces, again and again: it is off
  arm_slow,       // the arm's driver was too slow again and again
  arm_unchecked,  // nobody has seen that this arm's forces go where they are commanded (force_permit.h)
  not_armed       // since the start nobody has armed them, where somebody has to
};

constexpr bool heals(ForceFault fault) { return fault < ForceFault::overspeed; }
std::string_view name_of(ForceState state);
std::string_view name_of(ForceFault fault);

struct ForceCondition {
  ForceState state = ForceState::ready;
  ForceFault fault = ForceFault::none;
  bool operator==(const ForceCondition&) const = default;
};
std::string reason_text(const ForceCondition& condition);     // "", "overspeed"
std::string condition_text(const ForceCondition& condition);  // "running", "safe: overspeed"

}  // namespace palpate::device
