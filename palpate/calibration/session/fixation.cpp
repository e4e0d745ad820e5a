#include "palpate/calibration/session/fixation.h"

namespace palpate::calibration::session {

Fixation::Fixation(const FixationSettings& settings, const device::ArmSample& here)
    : settings_(settings),
      held_(device::phantom_tip(here.joints, settings.nominal).m),
      last_(held_),
      last_stamp_(here.stamp) {}

Vector3 Fixation::force(const device::ArmSample& sample) {
  const Vector3 tip = device::phantom_tip(sample.joints, settings_.nominal).m;
  const double dt = to_seconds(sample.stamp - last_stamp_);
  if (dt > 0.0) {
    speed_ += dt / (settings_.speed_filter_s + dt) * ((tip - last_) / dt - speed_);
    last_ = tip;
    last_stamp_ = sample.stamp;
  }
  displacement_ = (tip - held_).norm();
  return settings_.stiffness * (held_ - tip) - settings_.damping * speed_;
}

}  // namespace palpate::calibration::session
