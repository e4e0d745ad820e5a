// The last thing before the device: whatever comes in, what goes out is a number, within the peak, and within
// the slew limit of what went out before. It never acts while the chain before it is right; where it does,
// that is a trip, and the guard switches the forces off.
//
// Device's own axes, N. Haptic thread alone; no allocation.
#pragma once

#include "palpate/haptics/force_limits.h"
#include "palpate/math/so3.h"

namespace palpate::haptics {

class LastClamp {
 public:
  LastClamp(const ForceLimits& limits, double period)
      : peak_(limits.peak_n), step_(limits.slew_n_s * period) {}

  Vector3 pass(const Vector3& wanted) {
    constexpr double kRounding = 1e-9;
    Vector3 target = wanted.allFinite() && wanted.cwiseAbs().maxCoeff() < 1e100 ? wanted : Vector3::Zero();
    bool good = target == wanted;
    if (const double size = target.norm(); size > peak_) {
      good = good && size <= peak_ * (1.0 + kRounding);
      target *= peak_ / size;
    }
    Vector3 change = target - last_;
    if (const double size = change.norm(); size > step_) {
      good = good && size <= step_ * (1.0 + kRounding) + peak_ * kRounding;
      change *= step_ / size;
    }
    last_ += change;  // between two points of the ball of the peak: within it
    tripped_ = !good;
    return last_;
  }
  // The device has let go of all but this share of what went out.
  void let_go(double held) { last_ *= held; }
  bool tripped() const { return tripped_; }  // the last force was changed
  const Vector3& last() const { return last_; }

 private:
  double peak_, step_;
  Vector3 last_ = Vector3::Zero();
  bool tripped_ = false;
};

}  // namespace palpate::haptics
