#include "palpate/calibration/session/fixation.h"

namespace palpate::calibration::session {

Fixation::Fixation(const FixationSettings& settings, const device::ArmSample& here)
    : settings_(settings),
      arm_(device::make_kinematics(settings.nominal)),
      held_(tip(here)),
      last_(held_),
      last_stamp_(here.stamp) {}

Vector3 Fixation::tip(const device::ArmSample& sample) const {
  return arm_->pose(sample.joints, Vector3::Zero()).translation;
}

Vector3 Fixation::force(const device::ArmSample& sample) {
  const Vector3 tip = this->tip(sample);
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
