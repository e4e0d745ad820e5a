// The simulated person: hand, pointer and head, acting on what a procedure asks for.
//
// Moves only through the hand's spring, never the truth directly; knows the laboratory as somebody standing
// in it does. World frame, SI, true time. Its chance has purposes of its own. One thread.
#pragma once

#include <array>
#include <optional>

#include "palpate/core/random.h"
#include "palpate/device/person.h"
#include "palpate/sim/head_motion.h"
#include "palpate/sim/simulated_arm.h"

namespace palpate::sim {

class SimPerson : public device::Person {
 public:
  SimPerson(const config::WorldFile& world, const Truth& truth, std::uint64_t seed, SimulatedArm& arm,
            SimulatedHand& hand);

  Expected<void> ask(const device::Request& request) override;
  Expected<bool> ready() override { return there(); }

  // A player leads the stylus: gestures end.
  void play(const device::HandTarget& target, double t);

  // Called about once a millisecond, before the arm steps.
  void update(double t);

  const HeadMotion& head() const { return head_; }
  std::optional<Pose<World, Pointer>> pointer(double t) const;  // none: put down
  bool board_in_place() const { return gesture_ == device::Gesture::look_around_board; }
  bool playing() const { return playing_; }
  device::Gesture gesture() const { return gesture_; }

 private:
  bool there() const;
  struct JointPath {  // straight in joint angles, smooth in time
    Vector3 from = Vector3::Zero(), to = Vector3::Zero();
    double start = 0.0, duration = 1.0;
  };
  void follow_path(const JointPath& path, double t, const Quaternion& orientation);
  void lead(const Vector3& tip, const Vector3& velocity, const Quaternion& orientation);
  Vector3 hand_joints() const;
  Quaternion facing_tracker(const Vector3& normal, const Vector3& place) const;
  // A wide swing about the direction to the tracker: tilt up to `cone`, roll up to `roll`, rad.
  Quaternion swung(const Quaternion& neutral, const Vector3& place, double t, double cone, double roll) const;
  void swing_stylus(double t);
  void begin_pose_of_their_own();
  Expected<void> begin_shown_pose(const device::PoseTarget& target);
  Vector3 held_joints(int index) const;
  Expected<void> begin_touch(const device::Request& request);
  Vector3 wander_joints(double t) const;

  const config::WorldFile& world_;
  const Truth& truth_;
  SimulatedArm& arm_;
  SimulatedHand& hand_;
  HeadMotion head_;
  Vector3 tracker_;  // middle of its cameras
  Pose<ArmBase, World> X_base_world_;
  Random poses_, shown_, touches_, phases_;

  device::Gesture gesture_ = device::Gesture::rest;
  double now_ = 0.0, began_ = -1e9;
  bool playing_ = false, in_hollow_ = false;
  device::HandTarget played_;
  double played_at_ = 0.0;

  JointPath path_;
  Quaternion held_orientation_ = Quaternion::Identity(), neutral_ = Quaternion::Identity();
  std::array<double, 6> phase_{};

  struct PointerPlace {
    Vector3 tip = Vector3::Zero();
    Quaternion rotation = Quaternion::Identity();
  };
  std::optional<PointerPlace> pointer_from_, pointer_to_;
};

}  // namespace palpate::sim
