// Between two states a body follows the cubic that has their positions and velocities (Hermite): exact for
// free flight, and for what a hand moves better than a straight line by an order in the time step.
#include "palpate/scene/scene_state.h"

#include <algorithm>

namespace palpate::scene {
namespace {

// A body's free flight for `t` seconds, which may be negative.
BodyState fly(BodyState body, double t, const Vector3& gravity) {
  const Vector3 v = body.v();
  const Vector3 w(body.angular_velocity.data());
  body.set_p(body.p() + t * v + 0.5 * t * t * gravity);
  body.set_v(v + t * gravity);
  if (w.squaredNorm() > 0.0) body.set_q((so3_exp(t * w) * body.q()).normalized());
  return body;
}

BodyState between(const BodyState& a, const BodyState& b, double s, double h) {
  BodyState body = a;
  const double r = 1.0 - s;
  const Vector3 pa = a.p(), pb = b.p(), va = a.v(), vb = b.v();
  body.set_p((1.0 + 2.0 * s) * r * r * pa + s * s * (3.0 - 2.0 * s) * pb + h * s * r * (r * va - s * vb));
  body.set_v(r * va + s * vb);
  body.set_w(r * Vector3(a.angular_velocity.data()) + s * Vector3(b.angular_velocity.data()));
  body.set_q(a.q().slerp(s, b.q()).normalized());
  return body;
}

}  // namespace

SceneState interpolate(const SceneState& a, const SceneState& b, double s, const Vector3& gravity) {
  if (s <= 0.0) return a;
  if (s >= 1.0) return b;
  const Duration span = b.time - a.time;
  const double h = to_seconds(span);
  SceneState state = a;  // counters and contact are what had happened by then: the earlier state's
  state.time = a.time + seconds(s * h);
  const int bodies = std::min(a.body_count, b.body_count);
  for (int i = 0; i < bodies; ++i) {
    const auto k = static_cast<std::size_t>(i);
    if (a.bodies[k].jumps == b.bodies[k].jumps) {
      state.bodies[k] = between(a.bodies[k], b.bodies[k], s, h);
    } else if (s < 0.5) {
      state.bodies[k] = fly(a.bodies[k], s * h, gravity);
    } else {
      state.bodies[k] = fly(b.bodies[k], (s - 1.0) * h, gravity);
    }
  }
  for (std::size_t i = 0; i < 3; ++i) {
    state.impact.force[i] = (1.0 - s) * a.impact.force[i] + s * b.impact.force[i];
    state.continuous.force[i] = (1.0 - s) * a.continuous.force[i] + s * b.continuous.force[i];
  }
  return state;
}

SceneState extrapolate(const SceneState& a, Duration ahead) {
  SceneState state = a;
  state.time = a.time + ahead;
  for (int i = 0; i < a.body_count; ++i) {
    const auto k = static_cast<std::size_t>(i);
    state.bodies[k] = fly(a.bodies[k], to_seconds(ahead), Vector3::Zero());
  }
  return state;
}

}  // namespace palpate::scene
