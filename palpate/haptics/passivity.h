// Watches whether a force that answers to the tip's place gives out more energy than the hand has put in, as
// a sampled stiff wall does, and says how much damping takes it away again.
//
//   E += -f . (x_now - x_before)         energy the hand has put in, J; f was held in between: exact
//   E < -allowance: alpha = min((-E - allowance) / (T |v|^2), most),  f_damping = -alpha v
// Source: Hannaford, Ryu (2002), "Time-domain passivity control of haptic interfaces", IEEE Trans. Robotics
// and Automation 18; the exact sum for a held force: Ryu, Kim, Hannaford (2004). What the damper takes is
// part of the force held and comes into the next sum by itself. Each contact stands for itself: E is 0 where
// nothing is held or requested. Not for impacts, which are played by time and may give energy. World, SI.
// Haptic thread alone; no allocation.
#pragma once

#include <algorithm>
#include <cmath>

#include "palpate/math/so3.h"

namespace palpate::haptics {

class PassivityObserver {
 public:
  explicit PassivityObserver(double most_damping_n_s_m) : most_(most_damping_n_s_m) {}

  // Over the last tick `held` was held while the tip moved by `displacement`.
  void moved(const Vector3& held, const Vector3& displacement, bool in_contact) {
    if (!in_contact) {
      energy_ = 0.0;
      return;
    }
    const double work = held.dot(displacement);
    if (!std::isfinite(work)) return;
    energy_ = std::min(energy_ - work, kMostStored);
  }
  // Force to add for the coming tick, N.
  Vector3 damping(const Vector3& velocity, double period) {
    injected_ = 0.0;
    const double excess = -energy_ - kAllowance, power = period * velocity.squaredNorm();
    if (!(excess > 0.0) || !(power > 0.0) || !std::isfinite(power)) return Vector3::Zero();
    injected_ = std::min(excess / power, most_);
    return -injected_ * velocity;
  }
  double energy() const { return energy_; }      // J
  double injected() const { return injected_; }  // N s/m, of the last tick

 private:
  // Encoder steps of 0.03 mm under a few newtons come and go with 0.1 mJ.
  static constexpr double kAllowance = 1e-4;  // J
  // What a spring gives back at the end was put in before: 8.5 N on 360 N/m. More, as friction leaves it
  // behind, would hide what becomes active later.
  static constexpr double kMostStored = 0.1;  // J
  double most_, energy_ = 0.0, injected_ = 0.0;
};

}  // namespace palpate::haptics
