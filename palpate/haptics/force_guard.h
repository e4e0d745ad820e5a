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

#include "palpate/device/force_condition.h"
#include "palpate/device/force_strength.h"
#include "palpate/haptics/force_limits.h"

namespace palpate::haptics {

using device::ForceFault;
using device::ForceState;

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
  // Not `permitted`: safe from the start, and no rearm() helps. Not `armed`: safe until the first rearm().
  ForceGuard(const ForceLimits& limits, bool permitted, bool armed = true);

  void tick(const SafetyInputs& inputs);
  // Safe -> ready. False, and nothing changes, where it is not safe or its reason is still there.
  bool rearm();

  ForceState state() const { return state_; }
  ForceFault fault() const { return fault_; }
  double gain() const { return strength_.gain(); }  // 0 = off, 1 = full strength
  const device::ForceStrength& strength() const { return strength_; }

 private:
  ForceFault healing_fault(const SafetyInputs& inputs) const;
  ForceFault lasting_fault(const SafetyInputs& inputs) const;

  ForceLimits limits_;
  bool permitted_;
  ForceState state_ = ForceState::ready;
  ForceFault fault_ = ForceFault::none;
  ForceFault present_ = ForceFault::none;  // lasting fault seen in the last tick
  device::ForceStrength strength_;
};

}  // namespace palpate::haptics
