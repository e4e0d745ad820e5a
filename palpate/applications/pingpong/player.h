// A scripted player: sees what the graphics server shows, thinks, and says where the hand should be.
//
// It knows only shown states, each `reaction_s` after it was displayed and with a little noise; the scene as
// calibrated; and its own arm (how heavy and how stiff). From what it has seen of a flight it estimates that
// flight (fit_flight), predicts it over the table into the arm's reach, chooses a stroke that brings the ball
// back to the wall, and plans a path of bounded acceleration to be there. Times are of the physics clock as
// stamped in the shown states; `displayed` and `now` are of the same clock (the caller converts). One thread;
// deterministic for a seed.
#pragma once

#include <array>
#include <deque>
#include <optional>
#include <vector>

#include "palpate/applications/pingpong/pingpong.h"
#include "palpate/applications/pingpong/swing.h"
#include "palpate/devices/devices.h"
#include "palpate/model/phantom.h"
#include "palpate/physics/flight.h"

namespace palpate::pingpong {

// Where the stylus can be.
struct Reach {
  Pose<World, ArmBase> X_world_base;
  PhantomLengths lengths;
  std::array<Vector3, 2> joints{Vector3(-0.7854, -0.1745, -0.4363), Vector3(0.7854, 1.4835, 1.1345)};  // rad
  double margin = 0.05;  // rad, kept from the ends

  bool contains(const Vector3& tip_world) const;
  Vector3 home() const;  // a comfortable place for the tip, World
};

struct PlayerSettings {
  double reaction_s = 0.150;
  double aim_sd = 0.005;         // m: how well the bat meets the place it is meant for, drawn once per stroke
  double perception_sd = 0.002;  // m, per shown state and axis
  double max_acceleration = 30.0;
  // The player's notion of the own arm: a target ahead by (mass / stiffness) a makes the hand arrive in time.
  double hand_mass = 0.225, hand_stiffness = 250.0;
  double return_speed = 2.6;        // m/s towards the wall
  double return_height = 0.30;      // above the table, at the wall
  Physics physics = Physics::full;  // what it believes of balls
  std::uint64_t seed = 1;
};

class ScriptedPlayer {
 public:
  ScriptedPlayer(const SceneDescription& scene, const Reach& reach, const PlayerSettings& settings = {});

  void show(const WorldState& state, Instant<PhysicsClock> displayed);
  // Where the hand should be now. Call often (each millisecond to each picture).
  HandTarget act(Instant<PhysicsClock> now);

  // When the next stroke is meant to meet the ball, if one is planned.
  std::optional<Instant<PhysicsClock>> planned_hit() const;

 private:
  struct Seen {
    WorldState state;
    Instant<PhysicsClock> ready;
  };
  struct Plan {
    double begin = 0.0, hit = 0.0;  // s
    bool stroke = false;
    Quintic path;  // from begin on
    Quaternion rotation_from, rotation_to;
  };
  void notice(const WorldState& state, double now);
  void think(double now);
  void go_home(double now);
  HandState planned(double t) const;
  Quaternion turned(double t) const;
  Stroke stroke_for(const BallState& in, const Vector3& v_out) const;
  Stroke aim(const BallState& in, double speed) const;
  Quaternion hold(const Vector3& normal) const;
  Vector3 tip_for(const Vector3& ball, const Vector3& normal, const Quaternion& R) const;

  SceneDescription scene_;
  Reach reach_;
  PlayerSettings settings_;
  BallModel model_;
  Bounce bat_;
  std::array<BouncePlane, 2> planes_;
  Vector3 up_, near_, right_, wall_middle_, table_middle_;
  Random random_;
  std::deque<Seen> waiting_;
  std::vector<SeenBall> seen_;
  std::array<std::int32_t, 2> score_{};  // serves and hits, as shown
  Vector3 aim_error_ = Vector3::Zero();
  Vector3 home_;
  Quaternion home_rotation_;
  Plan plan_;
  // The target as given out.
  bool started_ = false;
  double last_ = 0.0;
  HandState target_;
  Quaternion target_rotation_;
};

}  // namespace palpate::pingpong
