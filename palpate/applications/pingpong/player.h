// The scripted player of ping-pong (devices/player.h).
//
// From what it has seen of a flight it estimates that flight (fit_flight), predicts it over the table into
// the arm's reach, chooses a stroke that brings the ball back to the wall and from there to itself, and plans
// a path of bounded speed and acceleration to be there. A stroke whose path, or whose way back, would leave
// the reach is not begun. One thread; deterministic for a seed.
#pragma once

#include <array>
#include <deque>
#include <optional>
#include <vector>

#include "palpate/applications/pingpong/pingpong.h"
#include "palpate/devices/player.h"
#include "palpate/physics/flight.h"

namespace palpate::pingpong {

// Bat that sends a ball from v_in to v_out (World, m/s): unit face normal towards the ball's side and speed
// along it.
struct Stroke {
  Vector3 normal = Vector3::UnitZ();
  double speed = 0.0;
};

class ScriptedPlayer : public Player {
 public:
  ScriptedPlayer(const SceneDescription& scene, const Reach& reach, const PlayerSettings& settings = {});

  void show(const WorldState& state, Instant<PhysicsClock> displayed) override;
  HandTarget act(Instant<PhysicsClock> now) override;

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
  GuidedHand hand_;
  bool started_ = false;
};

}  // namespace palpate::pingpong
