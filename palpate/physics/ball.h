// Flight and bounce of a table-tennis ball.
//
// Any inertial frame, SI. Pure functions on values, safe from any thread, no allocation. Source:
// docs/theory/ball-flight.md (Newton 1852 for the bounce of a shell; drag and Magnus coefficients fitted to
// recorded flights).
//   a = g - kD |v| v + kM w x v        kD = rho CD A / (2 m), per metre; kM dimensionless
#pragma once

#include "palpate/math/so3.h"

namespace palpate::physics {

struct BallModel {
  double radius = 0.020;  // m, ITTF law 2.03
  double mass = 0.0027;   // kg
  Vector3 gravity{0.0, -9.81, 0.0};
  // Drag grows with spin: kD = drag + drag_from_spin * min(1, S / 0.5) with the spin ratio S = R |w| / |v|.
  // The two ends are what recorded flights without spin (0.09 per m) and with strong spin (0.15 per m) ask
  // for.
  double drag = 0.09;
  double drag_from_spin = 0.06;
  double magnus = 0.0055;  // good for small spin only

  // The paper's ball: a point that falls. Integrated exactly.
  static BallModel paper() {
    BallModel model;
    model.drag = model.drag_from_spin = model.magnus = 0.0;
    return model;
  }
  bool ballistic() const { return drag == 0.0 && drag_from_spin == 0.0 && magnus == 0.0; }
};

struct BallState {
  Vector3 position = Vector3::Zero();  // of the centre
  Vector3 velocity = Vector3::Zero();
  Vector3 spin = Vector3::Zero();  // rad/s
};

Vector3 ball_acceleration(const BallModel& model, const Vector3& velocity, const Vector3& spin);

// Free flight for dt: exact without air, explicit midpoint with it (0.6 um off after 1 s at dt = 1 ms, 6.7
// m/s). Spin is kept. dt may be negative.
BallState fly(const BallModel& model, const BallState& ball, double dt);

// What a surface does to a ball. Friction 0 is the paper's mode; a ball that grips loses 2/5 of its slip
// (thin shell).
struct Bounce {
  double restitution = 0.93;
  double friction = 0.25;
};

// The ball leaves a surface with unit normal `normal` (towards the ball) that moves with `surface_velocity`
// at the contact. Nothing happens to a ball that is already leaving.
BallState bounce(const BallModel& model, const BallState& ball, const Vector3& normal, const Bounce& law,
                 const Vector3& surface_velocity = Vector3::Zero());

}  // namespace palpate::physics
