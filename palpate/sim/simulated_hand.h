// The hand that holds the stylus: a planned path, and the spring, damper and mass with which the arm muscles
// follow it.
//
// World frame, SI. The plan chases a target with bounded acceleration and speed; the hand pulls the stylus
// along the plan like a spring and damper, with the force that the planned acceleration needs added (a
// practised movement), so that only what disturbs it - a hit, the arm's own force - shows its softness. One
// thread; does not allocate.
#pragma once

#include "palpate/device/devices.h"

namespace palpate::sim {

enum class Grip {
  none,    // the stylus stands by itself
  follow,  // the hand leads the stylus
  swing,   // the hand turns the stylus and pulls at it, and leaves the place of the tip to the arm
};

struct HandSettings {
  double mass = 0.15, damping = 4.0, stiffness = 250.0;
  double max_acceleration = 30.0, max_speed = 3.0;
};

class SimulatedHand {
 public:
  static constexpr double kApproachRate = 20.0;  // 1/s: the last centimetres of a reach, per e-fold
  static constexpr double kSpeedRate = 80.0;     // 1/s: how fast the planned speed takes the wanted one

  SimulatedHand(const HandSettings& settings, const Vector3& place, const Quaternion& orientation)
      : settings_(settings), place_(place), target_place_(place), orientation_(orientation) {}

  // Takes the stylus where it is; the plan goes on from there.
  void take(Grip grip, const Vector3& place, const Vector3& velocity);
  Grip grip() const { return grip_; }
  void set_target(const Vector3& place, const Vector3& velocity, const Quaternion& orientation) {
    target_place_ = place;
    target_velocity_ = velocity;
    orientation_ = orientation;
  }
  void set_pull(const Vector3& force) { pull_ = force; }  // N, World; acts while swinging

  // Moves the plan on by h seconds.
  void step(double h);
  // How the hand pushes the stylus: with `force` (N, World) while it stands at `place`, by `stiffness` (N/m)
  // less for each metre further on, by `damping` (N s/m) less for its speed. `mass` is all that moves with
  // it.
  struct Push {
    Vector3 force = Vector3::Zero();
    double stiffness = 0.0, damping = 0.0;
  };
  Push push(const Vector3& place, double mass) const;

  double mass() const { return grip_ == Grip::none ? 0.0 : settings_.mass; }
  const Quaternion& orientation() const { return orientation_; }
  const Vector3& planned_place() const { return place_; }
  double distance_to_target() const { return (target_place_ - place_).norm(); }

 private:
  HandSettings settings_;
  Grip grip_ = Grip::none;
  Vector3 place_, velocity_ = Vector3::Zero(), acceleration_ = Vector3::Zero();  // of the plan
  Vector3 target_place_, target_velocity_ = Vector3::Zero(), pull_ = Vector3::Zero();
  Quaternion orientation_;
};

}  // namespace palpate::sim
