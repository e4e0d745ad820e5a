// How warm the motors are, and what force that leaves them: the full peak while they are cool, the continuous
// force when they are warm, a straight line between.
//
//   h' = (F^2 / Fc^2 - h) / tau            heat of the windings, 1 = what the continuous force Fc settles at
//   F_allowed = Fp                         h <= 0.8
//             = Fc + (Fp - Fc) (1 - h)/0.2  0.8 < h < 1
//             = min(Fc, Fp)                h >= 1
// Where |F| <= F_allowed, and ticks are short beside tau (Fc / 10 Fp of it), h never passes 1, so that the
// exponentially weighted root mean square of the force never passes Fc. First-order thermal model of a
// winding (copper loss ~ current^2 ~ force^2). Value; one thread.
#pragma once

#include <algorithm>
#include <cmath>

#include "palpate/haptics/force_limits.h"

namespace palpate::haptics {

class MotorHeat {
 public:
  explicit MotorHeat(const ForceLimits& limits)
      : peak_(limits.peak_n),
        continuous_(std::min(limits.continuous_n, limits.peak_n)),
        rated_(limits.continuous_n),
        tau_(limits.continuous_s) {}

  // A force of this size was held for `elapsed` seconds (finite, >= 0).
  void held(double force_n, double elapsed) {
    const double keep = std::exp(-elapsed / tau_), load = force_n / rated_;
    heat_ = keep * heat_ + (1.0 - keep) * load * load;
  }
  double heat() const { return heat_; }
  bool warm() const { return heat_ > kWarm; }
  double allowed_n() const {
    const double cool = std::clamp((1.0 - heat_) / (1.0 - kWarm), 0.0, 1.0);
    return continuous_ + (peak_ - continuous_) * cool;
  }

 private:
  static constexpr double kWarm = 0.8;
  double peak_, continuous_, rated_, tau_, heat_ = 0.0;
};

}  // namespace palpate::haptics
