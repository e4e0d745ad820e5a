// A stylus held or thrown, and the loop between it and a law: encoders that count in steps, a velocity filtered as
// the haptic loop does, and forces that come a tick late. Trapezoidal rule, ten steps a tick, which neither adds
// energy nor takes any.
#pragma once

#include <cmath>

#include "palpate/physics/tissue/tissue_law.h"

namespace palpate::physics::tissue {

struct PlantForTests {
  double mass = 0.075, damping = 0.0, stiffness = 0.0;  // of arm and hand together
  double encoder = 3e-5;                                // m; 0: none
  Vector3 place = Vector3::Zero(), velocity = Vector3::Zero(), target = Vector3::Zero();
  Vector3 push = Vector3::Zero();  // N, constant, of the hand

  // One tick with `law`; what it answers acts in the next.
  void tick(TissueLaw& law) {
    tip.time += Duration(1'000'000);
    const Vector3 seen = encoder > 0.0 ? Vector3((place / encoder).array().round() * encoder) : place;
    filter(seen);
    tip.X_world_tip.translation = seen;
    tip.velocity = filtered_velocity_;
    const Vector3 acts = given_;
    given_ = law.force(tip, 1e-3);
    move(acts + push);
  }
  bool forceless() const { return given_.isZero(0.0); }

  scene::TipState tip;

 private:
  void filter(const Vector3& seen) {
    if (!started_) filtered_ = seen;
    started_ = true;
    const Vector3 ahead = filtered_ + 1e-3 * filtered_velocity_, off = seen - ahead;
    filtered_ = ahead + 0.64 * off;
    filtered_velocity_ += 160.0 * off;  // theta 0.6
  }
  void move(const Vector3& force) {
    constexpr double kStep = 1e-4;
    // (v' - v) m / h = f - b (v + v') / 2 - k (x - target + h (v + v') / 4), solved for v'
    const double b = 0.5 * damping * kStep, k = 0.25 * stiffness * kStep * kStep;
    for (int i = 0; i < 10; ++i) {
      const Vector3 before = velocity;
      velocity = ((mass - b - k) * before + kStep * (force - stiffness * (place - target))) / (mass + b + k);
      place += 0.5 * kStep * (before + velocity);
    }
  }

  bool started_ = false;
  Vector3 filtered_ = Vector3::Zero(), filtered_velocity_ = Vector3::Zero(), given_ = Vector3::Zero();
};

}  // namespace palpate::physics::tissue
