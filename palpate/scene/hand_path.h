// How a scripted hand moves: quintic paths, and a target that leads the hand along a plan with bounded
// acceleration. World frame, SI; times in seconds of one clock. Pure but for HandTrajectory, which one thread
// uses.
#pragma once

#include <algorithm>
#include <array>

#include "palpate/math/so3.h"

namespace palpate::scene {

struct HandState {
  Vector3 position = Vector3::Zero(), velocity = Vector3::Zero(), acceleration = Vector3::Zero();
};

// The path of degree five between two states (Flash and Hogan 1985: least jerk): position, velocity,
// acceleration meet.
class Quintic {
 public:
  Quintic() = default;
  Quintic(const HandState& from, const HandState& to, double duration);
  HandState at(double t) const;  // clamped to [0, duration]
  Vector3 jerk(double t) const;
  double duration() const { return duration_; }
  double largest_speed() const;         // sampled
  double largest_acceleration() const;  // sampled

 private:
  std::array<Vector3, 6> c_{Vector3::Zero(), Vector3::Zero(), Vector3::Zero(),
                            Vector3::Zero(), Vector3::Zero(), Vector3::Zero()};
  double duration_ = 0.0;
};

// How a hand goes after its target, as its owner knows it: its acceleration is stiffness (target - hand) +
// damping (the difference of their velocities), per mass, 1/s^2 and 1/s.
struct HandLaw {
  double stiffness = 1600.0, damping = 80.0;
};

// The target that takes such a hand along a plan. The hand lags its target, so that is led ahead by the
// offset which the hand's own law asks for the planned acceleration; it runs with an acceleration that stays
// below `most_acceleration`, m/s^2, whatever the plan asks.
class HandTrajectory {
 public:
  HandTrajectory(const HandLaw& law, double most_acceleration, const Vector3& start,
                 const Vector3& velocity = Vector3::Zero())
      : law_(law), most_(most_acceleration) {
    target_.position = start;
    target_.velocity = velocity;
  }

  // Goes on to `now`; plan(t) is the HandState wanted then, jerk(t) its third derivative. Returns the target.
  template <typename Plan, typename Jerk>
  const HandState& follow(double now, const Plan& plan, const Jerk& jerk) {
    constexpr double kStep = 0.001, kLongest = 0.1, kOmega = 90.0;
    if (!started_) last_ = now;
    started_ = true;
    double t = std::max(last_, now - kLongest);
    while (t < now) {
      const double h = std::min(kStep, now - t);
      HandState want = plan(t);
      const Vector3 lead_rate = (want.acceleration - law_.stiffness * lead_) / law_.damping;
      want.position += lead_;
      want.velocity += lead_rate;
      want.acceleration += (jerk(t) - law_.stiffness * lead_rate) / law_.damping;
      lead_ += h * lead_rate;
      Vector3 a = want.acceleration + kOmega * kOmega * (want.position - target_.position) +
                  1.8 * kOmega * (want.velocity - target_.velocity);
      const double size = a.norm();
      if (size > most_) a *= most_ / size;
      target_.position += h * target_.velocity + 0.5 * h * h * a;
      target_.velocity += h * a;
      target_.acceleration = a;
      t += h;
    }
    last_ = now;
    return target_;
  }

 private:
  HandLaw law_;
  double most_;
  bool started_ = false;
  double last_ = 0.0;
  HandState target_;
  Vector3 lead_ = Vector3::Zero();  // of the target before the plan
};

}  // namespace palpate::scene
