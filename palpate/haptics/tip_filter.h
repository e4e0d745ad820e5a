// Velocity and turning rate of the stylus from its measured poses: a critically damped g-h (alpha-beta)
// filter.
//
//   g = 1 - theta^2, h = (1 - theta)^2     (Brookner 1998, "fading memory")
// theta is that of a millisecond; over dt it is theta^(dt / 1 ms), so that the lag is the same at any rate,
// and after a gap the velocity is the mean over the gap. With theta = 0.6 the velocity lags an acceleration
// by about 2 ms, and an encoder step of 0.03 mm shows as a few mm/s instead of 30. World frame, SI. Haptic
// thread alone; no allocation.
#pragma once

#include <cmath>

#include "palpate/math/pose.h"

namespace palpate::haptics {

class TipFilter {
 public:
  explicit TipFilter(double theta_position = 0.6, double theta_rotation = 0.8)
      : theta_position_(theta_position), theta_rotation_(theta_rotation) {}

  // `dt`: between this measurement and the one before, s, > 0.
  void update(const Pose<World, Tip>& measured, double dt) {
    if (!started_) {
      pose_ = measured;
      started_ = true;
      return;
    }
    const auto g = [](double t) { return 1.0 - t * t; };
    const auto h = [](double t) { return (1.0 - t) * (1.0 - t); };
    const double position = std::pow(theta_position_, dt / 1e-3),
                 rotation = std::pow(theta_rotation_, dt / 1e-3);
    const Vector3 ahead = pose_.translation + dt * velocity_;
    const Vector3 off = measured.translation - ahead;
    pose_.translation = ahead + g(position) * off;
    velocity_ += h(position) / dt * off;
    const Quaternion turned = so3_exp(dt * angular_velocity_) * pose_.rotation;
    const Vector3 twist = so3_log(measured.rotation * turned.conjugate());
    pose_.rotation = (so3_exp(g(rotation) * twist) * turned).normalized();
    angular_velocity_ += h(rotation) / dt * twist;
  }
  const Vector3& velocity() const { return velocity_; }
  const Vector3& angular_velocity() const { return angular_velocity_; }

 private:
  double theta_position_, theta_rotation_;
  bool started_ = false;
  Pose<World, Tip> pose_;
  Vector3 velocity_ = Vector3::Zero(), angular_velocity_ = Vector3::Zero();
};

}  // namespace palpate::haptics
