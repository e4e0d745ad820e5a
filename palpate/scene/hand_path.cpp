#include "palpate/scene/hand_path.h"

namespace palpate::scene {

Quintic::Quintic(const HandState& from, const HandState& to, double duration) : duration_(duration) {
  const double T = duration, T2 = T * T;
  const Vector3 dp = to.position - from.position - T * from.velocity - 0.5 * T2 * from.acceleration;
  const Vector3 dv = T * (to.velocity - from.velocity - T * from.acceleration);
  const Vector3 da = T2 * (to.acceleration - from.acceleration);
  c_[0] = from.position;
  c_[1] = from.velocity;
  c_[2] = 0.5 * from.acceleration;
  c_[3] = (10.0 * dp - 4.0 * dv + 0.5 * da) / (T2 * T);
  c_[4] = (-15.0 * dp + 7.0 * dv - da) / (T2 * T2);
  c_[5] = (6.0 * dp - 3.0 * dv + 0.5 * da) / (T2 * T2 * T);
}

HandState Quintic::at(double t) const {
  t = std::clamp(t, 0.0, duration_);
  HandState s;
  s.position = c_[0] + t * (c_[1] + t * (c_[2] + t * (c_[3] + t * (c_[4] + t * c_[5]))));
  s.velocity = c_[1] + t * (2.0 * c_[2] + t * (3.0 * c_[3] + t * (4.0 * c_[4] + t * 5.0 * c_[5])));
  s.acceleration = 2.0 * c_[2] + t * (6.0 * c_[3] + t * (12.0 * c_[4] + t * 20.0 * c_[5]));
  return s;
}

Vector3 Quintic::jerk(double t) const {
  t = std::clamp(t, 0.0, duration_);
  return 6.0 * c_[3] + t * (24.0 * c_[4] + t * 60.0 * c_[5]);
}

double Quintic::largest_speed() const {
  double most = 0.0;
  for (int i = 0; i <= 16; ++i) most = std::max(most, at(duration_ * i / 16).velocity.norm());
  return most;
}

double Quintic::largest_acceleration() const {
  double most = 0.0;
  for (int i = 0; i <= 16; ++i) most = std::max(most, at(duration_ * i / 16).acceleration.norm());
  return most;
}

}  // namespace palpate::scene
