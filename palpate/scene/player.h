// A scripted player: sees what the graphics server shows, and says where the hand should be. Each application
// that can be played without a person has one.
//
// It knows only shown states, each `reaction_s` after it was displayed and with a little noise; the scene as
// calibrated; and its own arm (where it reaches, how the hand goes after a target). World frame, SI. Times
// are of the physics clock as stamped in the shown states; `displayed` and `now` are of the same clock (the
// caller converts). One thread; deterministic for a seed.
#pragma once

#include <optional>

#include "palpate/device/devices.h"
#include "palpate/device/phantom.h"
#include "palpate/scene/hand_path.h"
#include "palpate/scene/scene_state.h"

namespace palpate::scene {

// Where the stylus can be.
struct Reach {
  Pose<World, ArmBase> X_world_base;
  device::PhantomLengths lengths;
  std::array<Vector3, 2> joints{Vector3(-0.7854, -0.1745, -0.4363), Vector3(0.7854, 1.4835, 1.1345)};  // rad
  double widest_elbow = 1.40;  // rad, theta2 - theta3: at pi/2 the elbow is stretched
  double margin = 0.05;        // rad, kept from the ends

  bool contains(const Vector3& tip_world) const;
  bool contains(const Quintic& path) const;  // sampled
  Vector3 home() const;                      // a comfortable place for the tip, World
};

struct PlayerSettings {
  double reaction_s = 0.150;
  double aim_sd = 0.005;  // m: how well a stroke meets the place it is meant for, drawn once per stroke
  double perception_sd = 0.002;                     // m, per shown state and axis
  double max_acceleration = 30.0, max_speed = 2.2;  // of the tip: the arm's motors switch off at 3 m/s
  HandLaw hand;  // the player's notion of the own hand, learnt by moving it
  double wrist_rate =
      30.0;  // rad/s: the wrist turns after its target, critically damped, with this frequency
  std::uint64_t seed = 1;
};

class Player {
 public:
  virtual ~Player() = default;
  // Called as a picture appears, with what it shows. The delay of a person is the player's own to keep: what it
  // was shown it may use from `displayed` + reaction_s on.
  virtual void show(const SceneState& state, Instant<PhysicsClock> displayed) = 0;
  // Where the hand should be now. Call often (each millisecond to each picture).
  virtual device::HandTarget act(Instant<PhysicsClock> now) = 0;
  // Somebody else has led the hand meanwhile and leaves it there: the player goes on from there, and thinks
  // no more of what it was shown before.
  virtual void take_over(const device::HandTarget& at, Instant<PhysicsClock> now) = 0;
};

// What a person does who leads the stylus with a mouse: where it would be without help, and the ray on which
// the pointer lies.
struct Led {
  device::HandTarget hand;
  Vector3 eye = Vector3::Zero(), ray = -Vector3::UnitZ();  // unit
  double side = 0.0;                                       // -1 ... 1: a button asks for the left, the right
};

// What nobody can steer with a mouse: how to turn and swing what the hand holds, at the right moment. Knows
// shown states alone, as a player does, and the own arm; where the hand goes, the person says.
class InputAssist {
 public:
  virtual ~InputAssist() = default;
  virtual void show(const SceneState& state) = 0;
  // Where the hand should be now instead; none: where it is led. Call every millisecond or so.
  virtual std::optional<device::HandTarget> act(Instant<PhysicsClock> now, const Led& led) = 0;
};

}  // namespace palpate::scene
