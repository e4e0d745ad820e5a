// Whether a sampled contact has given out energy that the hand has not put in, and the damping that takes it back.
//
// Forces are computed once a tick and held; what the tip does meanwhile they do not know, and a device may be a
// tick late. So two sums are kept, of the work done against the force of the last tick and of the one before it,
// and the lesser counts:
//   E += -f . moved;   missing = stored - min(E);   damping = min(missing / (T |v|^2), most)
// `stored` is what the model holds now. Waiting until E is below zero, as a plain observer does, acts when the tip
// is leaving already; following the model's own energy acts in the same tick. What the contact has dissipated is no
// credit for later: E never exceeds what is stored by more than kCredit.
// Body's frame, SI. One thread; no allocation.
// Source: Hannaford and Ryu 2002, "Time-domain passivity control of haptic interfaces", IEEE Trans. Robotics and
// Automation 18; Ryu, Preusche, Hannaford, Hirzinger 2005, "Time domain passivity control with reference energy
// following", IEEE Trans. Control Systems Technology 13.
#pragma once

#include <algorithm>
#include <cmath>

#include "palpate/math/so3.h"

namespace palpate::physics::tissue {

class EnergyAccount {
 public:
  explicit EnergyAccount(double most_damping_n_s_m) : most_(most_damping_n_s_m) {}

  void reset() { *this = EnergyAccount(most_); }

  // The tip has `moved` since the last tick.
  void moved(const Vector3& way) {
    const double now = -last_.dot(way), late = -before_.dot(way);
    if (!std::isfinite(now + late)) return;
    at_once_ += now;
    late_ += late;
    put_in_ += std::min(now, late);
  }
  // The coefficient of damping for the coming tick, N s/m.
  double damping(double stored, const Vector3& velocity, double dt) {
    missing_ = std::max(0.0, stored - std::min(at_once_, late_) - kAllowance);
    at_once_ = std::min(at_once_, stored + kCredit);
    late_ = std::min(late_, stored + kCredit);
    const double power = dt * velocity.squaredNorm();
    return missing_ > 0.0 && power > 1e-12 ? std::min(missing_ / power, most_) : 0.0;
  }
  // Others have put in so much, J.
  void credit(double energy) {
    if (!std::isfinite(energy)) return;
    at_once_ += energy;
    late_ += energy;
    put_in_ += energy;
  }
  // The force of this tick.
  void give(const Vector3& force) {
    before_ = last_;
    last_ = force;
  }

  double missing() const { return missing_; }  // J
  // J: by which the contact has so far given out more than was put in, at the worse of the two delays in each tick.
  double created() const { return std::max(0.0, -put_in_); }

 private:
  // Encoder steps of 0.03 mm on 700 N/m come and go with less than a microjoule.
  static constexpr double kAllowance = 1e-6, kCredit = 2e-6;  // J
  double most_, at_once_ = 0.0, late_ = 0.0, put_in_ = 0.0, missing_ = 0.0;
  Vector3 last_ = Vector3::Zero(), before_ = Vector3::Zero();
};

}  // namespace palpate::physics::tissue
