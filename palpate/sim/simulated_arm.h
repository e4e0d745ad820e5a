// The simulated haptic arm: a PHANToM with encoders, motors and a stylus that a hand may hold.
//
// Or, in a world whose arm is a delta, one of the same reach that states its tip's place: the hand moves it alike, and
// what it states and pushes goes through the delta's geometry (delta_arm.h).
//
// What it shows to the outside is what the real one shows: quantised readings through unknown gains and
// offsets, and a motor force that passes through the device's own idea of its geometry. Inside, World frame
// and SI. Dynamics: a point mass at the tip (apparent mass of the arm plus the hand's), since the PHANToM is
// counterweighted and light; the stylus' orientation follows the hand, critically damped. Joint angles follow
// from the tip by the inverse kinematics, once per millisecond and whenever read. Poses beyond the singular
// line (t2 - t3 near 90 degrees) are out of its reach, as the elbow of the real arm cannot pass it under
// load. One thread; stepping does not allocate.
#pragma once

#include <optional>

#include "palpate/device/devices.h"
#include "palpate/device/phantom.h"
#include "palpate/sim/simulated_hand.h"
#include "palpate/sim/truth.h"

namespace palpate::sim {

// To the nearest whole step, as an encoder reads; exact where the step is 0.
double quantised(double value, double quantum);

class SimulatedArm {
 public:
  static constexpr double kTurnRate = 30.0;   // rad/s, natural frequency of the wrist turning the stylus
  static constexpr double kFoldLimit = 1.45;  // rad, largest t2 - t3: the singular line is at pi/2

  SimulatedArm(const config::WorldFile& world, const Truth& truth);

  // One integration step of h seconds.
  void step(double h, SimulatedHand& hand);
  // Force wanted at the tip, N, ArmBase axes as the device's nominal kinematics sees them; clamped to its
  // limit, and let go of after kLongestHold without another.
  void command(const Vector3& force);
  const Vector3& held() const { return commanded_; }  // as command() has it

  // The moving state, which a caller may interpolate.
  struct State {
    Vector3 tip = Vector3::Zero(), velocity = Vector3::Zero();
    Quaternion orientation = Quaternion::Identity();  // stylus in World
    Vector3 spin = Vector3::Zero();                   // rad/s, World
  };
  const State& state() const { return state_; }
  // The tip stands in a hollow whose bottom is here (World), metal on metal, until it is lifted out (nothing).
  void rest_in(const std::optional<Vector3>& hollow) { hollow_ = hollow; }
  // Puts the stylus somewhere at rest (start of a session, tests).
  void place(const Vector3& tip, const Quaternion& orientation);

  // True joint and gimbal angles of a state.
  Vector3 theta_of(const State& state) const;
  Vector3 gimbal_of(const State& state, const Vector3& theta) const;
  // Encoder readings of a state: hysteresis as left by the motion so far, quantised.
  Vector3 joint_readings(const Vector3& theta) const;
  // What the device says of a state: these, or the place that a delta states, m, ArmBase.
  Vector3 readings(const State& state, const Vector3& theta) const;
  Vector3 gimbal_readings(const Vector3& gimbal) const;
  // What the device says of a state; a delta's handle tells its turn in ArmBase.
  Vector3 gimbal_readings(const State& state, const Vector3& theta) const;

  Vector3 motor_force() const { return motor_force_; }  // what the motors really push with, N, World
  // The reachable pose nearest in joint angles; targets of a person or a player pass through it.
  Vector3 within_reach(const Vector3& tip) const;
  // Joint limits: the stated range, which the mechanical stops exceed by a little.
  bool within_range(const Vector3& theta) const;

 private:
  void update_joints();
  Vector3 torques(const Vector3& force) const;  // as the device makes them, by its own kinematics
  Matrix3 true_jacobian() const;
  Vector3 miswired(const Vector3& torque) const;
  Vector3 clamped(const Vector3& theta) const;
  // Places beyond so large a share of the stretched arm (or within the folded one): on its edge, in line with the shoulder.
  Vector3 back_in_reach(const Vector3& in_base, double share) const;

  device::PhantomLengths lengths_, nominal_;
  device::JointCorrection joints_, gimbal_;
  std::optional<DeltaArm> delta_;  // as it was built
  DeltaArm made_;                  // as its maker describes it
  Pose<World, ArmBase> X_world_base_;
  Pose<ArmBase, World> X_base_world_;
  std::array<config::Range, 3> range_;
  bool faulty_ = false;  // any of:
  Vector3 axis_signs_;   // of ArmBase
  std::array<int, 2> exchanged_;
  Vector3 torque_gains_;
  double mass_, friction_, max_force_, max_speed_, hysteresis_, joint_quantum_, gimbal_quantum_;

  State state_;
  std::optional<Vector3> hollow_;
  Vector3 theta_ = Vector3::Zero();      // at the last update
  Vector3 followed_ = Vector3::Zero();   // theta as the encoders feel it behind the backlash
  Vector3 commanded_ = Vector3::Zero();  // N, ArmBase
  Vector3 motor_force_ = Vector3::Zero(), stop_force_ = Vector3::Zero();
  double since_update_ = 0.0, since_command_ = 0.0;  // s
};

}  // namespace palpate::sim
