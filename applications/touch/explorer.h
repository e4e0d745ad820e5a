// The scripted player of touch (palpate/scene/player.h): taps what it is shown and strokes it.
//
// Again and again it chooses two places on the upper side that its arm reaches, comes down on the first until
// it should be felt, holds, strokes to the second and back at another speed, and lifts off. How deep it
// presses it learns from the force that is shown, as late as everything it sees. It knows the surface's shape
// and takes its place from the pictures. One thread; deterministic for a seed.
#pragma once

#include <deque>
#include <optional>

#include "applications/touch/touch.h"
#include "palpate/core/random.h"
#include "palpate/scene/player.h"

namespace palpate::applications::touch {

class Explorer : public scene::Player {
 public:
  Explorer(const scene::SceneDescription& scene, const scene::Reach& reach,
           const scene::PlayerSettings& settings);

  void show(const scene::SceneState& state, Instant<PhysicsClock> displayed) override;
  device::HandTarget act(Instant<PhysicsClock> now) override;
  void take_over(const device::HandTarget& at, Instant<PhysicsClock> now) override;

 private:
  enum class Doing { waiting, travelling, coming_down, holding, stroking, stroking_back, lifting };
  struct Seen {
    scene::SceneState state;
    Instant<PhysicsClock> ready;
  };
  struct Move {                          // over the surface in the Organ frame, from rest to rest
    double begin = 0.0, duration = 1.0;  // s
    Vector3 from, to;                    // x, height above rest (below: pressed), z
  };

  void notice(const scene::SceneState& state);
  void next(double now);
  bool choose();
  void move(double now, const Vector3& to, double duration);
  std::optional<double> resting_height(double x, double z) const;
  Vector3 place(double t) const;
  scene::HandState planned(double t) const;
  bool on_surface() const;

  scene::Reach reach_;
  scene::PlayerSettings settings_;
  scene::TriangleMesh surface_;
  physics::CollisionMesh mesh_;
  double top_ = 0.0;                // of the surface above its origin, m
  Vector3 half_ = Vector3::Zero();  // of its box
  Random random_;
  std::deque<Seen> waiting_;
  bool known_ = false;  // where the surface is has been seen
  Pose<World, Organ> X_world_organ_;
  Doing doing_ = Doing::waiting;
  Move move_;
  scene::Quintic travel_;  // World
  double travel_begin_ = 0.0;
  Vector3 here_, there_;  // x, 0, z of the two places of this round
  double press_ = 0.0;    // m below rest, as learnt so far
  double felt_ = 0.0;     // N, as shown
  double last_ = 0.0;
  double try_at_ = 0.0;  // s: not before is another pair of places looked for
  int rounds_ = 0;
  scene::HandTrajectory hand_;
};

}  // namespace palpate::applications::touch
