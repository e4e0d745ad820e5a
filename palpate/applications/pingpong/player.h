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
#include "palpate/applications/pingpong/strokes.h"
#include "palpate/devices/player.h"
#include "palpate/physics/flight.h"

namespace palpate::pingpong {

class ScriptedPlayer : public Player {
 public:
  ScriptedPlayer(const SceneDescription& scene, const Reach& reach, const PlayerSettings& settings = {});

  void show(const WorldState& state, Instant<PhysicsClock> displayed) override;
  HandTarget act(Instant<PhysicsClock> now) override;
  void take_over(const HandTarget& at, Instant<PhysicsClock> now) override;

  // When the next stroke is meant to meet the ball, if one is planned.
  std::optional<Instant<PhysicsClock>> planned_hit() const;

 private:
  struct Seen {
    WorldState state;
    Instant<PhysicsClock> ready;
  };
  void notice(const WorldState& state, double now);
  void think(double now);
  void go_home(double now);
  void go_home(const HandState& from, const Quaternion& turned, double now);

  PlayerSettings settings_;
  Strokes strokes_;
  Random random_;
  std::deque<Seen> waiting_;
  std::vector<SeenBall> seen_;
  std::array<std::int32_t, 2> score_{};  // serves and hits, as shown
  Vector3 aim_error_ = Vector3::Zero();
  Swing plan_;
  GuidedHand hand_;
  bool started_ = false;
};

}  // namespace palpate::pingpong
