// A scripted player: sees what the graphics server shows, thinks, and says where the hand should be.
//
// It knows only shown states, each `reaction_s` after it was displayed and with a little noise; the scene as
// calibrated; and its own arm (where it reaches, how it goes after a target). From what it has seen of a
// flight it estimates that flight (fit_flight), predicts it over the table into the arm's reach, chooses a
// stroke that brings the ball back to the wall and from there to itself, and plans a path of bounded speed
// and acceleration to be there. A stroke whose path, or whose way back, would leave the reach is not begun.
// Times are of the physics clock as stamped in the shown states; `displayed` and `now` are of the same clock
// (the caller converts). One thread; deterministic for a seed.
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
  double widest_elbow = 1.40;  // rad, theta2 - theta3: at pi/2 the elbow is stretched
  double margin = 0.05;        // rad, kept from the ends

  bool contains(const Vector3& tip_world) const;
  bool contains(const Quintic& path) const;  // sampled
  Vector3 home() const;                      // a comfortable place for the tip, World
};

struct PlayerSettings {
  double reaction_s = 0.150;
  double aim_sd = 0.005;         // m: how well the bat meets the place it is meant for, drawn once per stroke
  double perception_sd = 0.002;  // m, per shown state and axis
  double max_acceleration = 30.0, max_speed = 2.2;  // of the tip: the arm's motors switch off at 3 m/s
  // The player's notion of the own hand, learnt by moving it: its acceleration is hand_stiffness (target -
  // hand) + hand_damping (the difference of their velocities), per mass, 1/s^2 and 1/s; the wrist turns
  // after its target with this natural frequency, critically damped, rad/s.
  double hand_stiffness = 1600.0, hand_damping = 80.0, wrist_rate = 30.0;
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
  std::optional<Plan> swing_to(const BallState& ball, double hit, double faster, double higher,
                               double now) const;
  Quintic way_home(const HandState& from) const;
  void go_home(double now);
  HandState planned(double t) const;
  Quaternion turned(double t) const;
  Stroke stroke_for(const BallState& in, const Vector3& v_out) const;
  Stroke aim(const BallState& in, double speed, double height) const;
  void choose_return();
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
  Vector3 home_, meeting_;  // of the tip; of the ball, where the bat at home would meet it
  double return_speed_ = 2.6, return_height_ = 0.30;  // towards the wall, m/s; above the table at the wall, m
  Quaternion home_rotation_;
  Plan plan_;
  // The target as given out.
  bool started_ = false;
  double last_ = 0.0;
  HandState target_;
  Vector3 lead_ = Vector3::Zero();  // of the target before the plan
  Quaternion target_rotation_;
};

}  // namespace palpate::pingpong
