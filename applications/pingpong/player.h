// The scripted player of ping-pong (palpate/scene/player.h).
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

#include "applications/pingpong/pingpong.h"
#include "applications/pingpong/strokes.h"
#include "palpate/physics/flight.h"
#include "palpate/scene/player.h"

namespace palpate::applications::pingpong {

class ScriptedPlayer : public scene::Player {
 public:
  ScriptedPlayer(const scene::SceneDescription& scene, const scene::Reach& reach,
                 const scene::PlayerSettings& settings = {});

  void show(const scene::SceneState& state, Instant<PhysicsClock> displayed) override;
  device::HandTarget act(Instant<PhysicsClock> now) override;
  void take_over(const device::HandTarget& at, Instant<PhysicsClock> now) override;

 private:
  struct Seen {
    scene::SceneState state;
    Instant<PhysicsClock> ready;
  };
  void notice(const scene::SceneState& state, double now);
  void think(double now);
  void go_home(double now);
  void go_home(const scene::HandState& from, const Quaternion& turned, double now);

  scene::PlayerSettings settings_;
  Strokes strokes_;
  Random random_;
  std::deque<Seen> waiting_;
  std::vector<physics::SeenBall> seen_;
  std::array<std::int32_t, 2> score_{};  // serves and hits, as shown
  Vector3 aim_error_ = Vector3::Zero();
  Swing plan_;
  scene::HandTrajectory hand_;
  bool started_ = false;
};

}  // namespace palpate::applications::pingpong
