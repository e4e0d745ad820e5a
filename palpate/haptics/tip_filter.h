// Velocity and turning rate of the stylus from its measured poses: a critically damped g-h (alpha-beta)
// filter.
//
//   g = 1 - theta^2, h = (1 - theta)^2     (Brookner 1998, "fading memory")
// With theta = 0.6 at 1 kHz the velocity lags an acceleration by about 2 ms, and an encoder step of 0.03 mm
// shows as a few mm/s instead of 30. World frame, SI. Haptic thread alone; no allocation.
#pragma once

#include "palpate/geometry/pose.h"

namespace palpate {

class TipFilter {
 public:
  explicit TipFilter(double theta_position = 0.6, double theta_rotation = 0.8)
      : theta_position_(theta_position), theta_rotation_(theta_rotation) {}

  void update(const Pose<World, Tip>& measured, double dt) {
    if (!started_) {
      pose_ = measured;
      started_ = true;
      return;
    }
    const auto g = [](double t) { return 1.0 - t * t; };
    const auto h = [](double t) { return (1.0 - t) * (1.0 - t); };
    const Vector3 ahead = pose_.translation + dt * velocity_;
    const Vector3 off = measured.translation - ahead;
    pose_.translation = ahead + g(theta_position_) * off;
    velocity_ += h(theta_position_) / dt * off;
    const Quaternion turned = so3_exp(dt * angular_velocity_) * pose_.rotation;
    const Vector3 twist = so3_log(measured.rotation * turned.conjugate());
    pose_.rotation = (so3_exp(g(theta_rotation_) * twist) * turned).normalized();
    angular_velocity_ += h(theta_rotation_) / dt * twist;
  }
  const Vector3& velocity() const { return velocity_; }
  const Vector3& angular_velocity() const { return angular_velocity_; }

 private:
  double theta_position_, theta_rotation_;
  bool started_ = false;
  Pose<World, Tip> pose_;
  Vector3 velocity_ = Vector3::Zero(), angular_velocity_ = Vector3::Zero();
};

}  // namespace palpate
