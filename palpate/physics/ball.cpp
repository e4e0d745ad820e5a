#include "palpate/physics/ball.h"

#include <algorithm>

namespace palpate::physics {

Vector3 ball_acceleration(const BallModel& model, const Vector3& velocity, const Vector3& spin) {
  constexpr double kSaturatedSpinRatio = 0.5;
  const double speed = velocity.norm();
  const double rim = model.radius * spin.norm();
  const double s =
      rim < kSaturatedSpinRatio * speed ? rim / (kSaturatedSpinRatio * speed) : (rim > 0.0 ? 1.0 : 0.0);
  const double drag = model.drag + model.drag_from_spin * s;
  return model.gravity - drag * speed * velocity + model.magnus * spin.cross(velocity);
}

BallState fly(const BallModel& model, const BallState& ball, double dt) {
  BallState next = ball;
  if (model.ballistic()) {
    next.position += dt * ball.velocity + 0.5 * dt * dt * model.gravity;
    next.velocity += dt * model.gravity;
    return next;
  }
  const Vector3 half = ball.velocity + 0.5 * dt * ball_acceleration(model, ball.velocity, ball.spin);
  const Vector3 a = ball_acceleration(model, half, ball.spin);
  next.position += dt * ball.velocity + 0.5 * dt * dt * a;
  next.velocity += dt * a;
  return next;
}

BallState bounce(const BallModel& model, const BallState& ball, const Vector3& normal, const Bounce& law,
                 const Vector3& surface_velocity) {
  const Vector3 relative = ball.velocity - surface_velocity;
  const double approach = -normal.dot(relative);
  if (approach <= 0.0) return ball;
  BallState after = ball;
  after.velocity += (1.0 + law.restitution) * approach * normal;
  if (law.friction > 0.0) {
    const Vector3 slip = relative + approach * normal - model.radius * ball.spin.cross(normal);
    const double speed = slip.norm();
    if (speed > 0.0) {
      const double grip = std::min(0.4, law.friction * (1.0 + law.restitution) * approach / speed);
      const Vector3 dv = -grip * slip;
      after.velocity += dv;
      after.spin -= 1.5 / model.radius * normal.cross(dv);
    }
  }
  return after;
}

}  // namespace palpate::physics
