// Whether forces may be given, and how strong: what is watched in every tick, and the state that follows.
//
//              all is well                     a fault that heals
//   ready ------------------> running <-----------------------------> degraded
//     ^                          |                                      |
//     |  rearm()                 v      a fault that does not heal      v
//     +------------------------ safe <----------------------------------+   (also from ready)
//
// Ready: no force yet, nothing wrong. Running: forces, along the start ramp first. Degraded: forces fade
// within fade_s, and come back when the reason has gone, as ForceStrength says; also while the motors are
// warm and the peak is lowered. Safe: forces have faded and stay off until somebody re-arms. Haptic thread
// alone; no allocation.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "palpate/device/force_strength.h"
#include "palpate/haptics/force_limits.h"

namespace palpate::haptics {

enum class HapticState : std::uint8_t { ready, running, degraded, safe };

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
  arm_unchecked   // nobody has seen that this arm's forces go where they are commanded (force_permit.h)
};

constexpr bool heals(ForceFault fault) { return fault < ForceFault::overspeed; }
std::string_view name_of(HapticState state);
std::string_view name_of(ForceFault fault);
std::string condition_text(HapticState state, ForceFault fault);  // "running", "safe: overspeed"

// What a tick sees. Ages are infinite where nothing has ever come.
struct SafetyInputs {
  double input_age_s = 0.0;    // of physics' newest state
  double reading_age_s = 0.0;  // of the arm's newest good reading
  double elapsed_s = 0.0;      // since the tick before
  double held = 1.0;           // share of the last command that the device still gave when this tick began
  double tip_speed = 0.0;      // m/s
  bool connected = true, reading_good = true, inside_workspace = true, requested_good = true,
       clamp_good = true, law_good = true, arm_quick = true, button_held = true;
  bool warm = false;
};

class ForceGuard {
 public:
  // Not `permitted`: safe from the start, and no rearm() helps.
  ForceGuard(const ForceLimits& limits, bool permitted);

  void tick(const SafetyInputs& inputs);
  // Safe -> ready. False, and nothing changes, where it is not safe or its reason is still there.
  bool rearm();

  HapticState state() const { return state_; }
  ForceFault fault() const { return fault_; }
  double gain() const { return strength_.gain(); }  // 0 = off, 1 = full strength
  const device::ForceStrength& strength() const { return strength_; }

 private:
  ForceFault healing_fault(const SafetyInputs& inputs) const;
  ForceFault lasting_fault(const SafetyInputs& inputs) const;

  ForceLimits limits_;
  bool permitted_;
  HapticState state_ = HapticState::ready;
  ForceFault fault_ = ForceFault::none;
  ForceFault present_ = ForceFault::none;  // lasting fault seen in the last tick
  device::ForceStrength strength_;
};

}  // namespace palpate::haptics
