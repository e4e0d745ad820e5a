// The scripted player: prods the jelly at one place after the other, holds, lets go and watches it wobble.
//
// It knows the scene and its own arm, and presses as deep as a number of millimetres of its own; what it feels does not
// lead it. One thread; deterministic for a seed.
#pragma once

#include "mould.h"
#include "palpate/core/random.h"
#include "palpate/scene/player.h"

namespace jelly {

class Prodder : public palpate::scene::Player {
 public:
  Prodder(const palpate::scene::SceneDescription& scene, const palpate::scene::Reach& reach,
          const palpate::scene::PlayerSettings& settings);

  void show(const palpate::scene::SceneState&, palpate::Instant<palpate::PhysicsClock>) override {}
  palpate::device::HandTarget act(palpate::Instant<palpate::PhysicsClock> now) override;
  void take_over(const palpate::device::HandTarget& at, palpate::Instant<palpate::PhysicsClock> now) override;

 private:
  enum class Doing { coming, pressing, holding, letting_go, watching };

  void next(double now);
  void choose();
  void go(double now, const palpate::Vector3& to, double duration);
  palpate::Vector3 above(double height) const;  // the place chosen, World; below 0: into it

  palpate::scene::Reach reach_;
  palpate::scene::PlayerSettings settings_;
  palpate::Pose<palpate::World, JellyFrame> X_world_jelly_;
  palpate::Random random_;
  palpate::scene::TriangleMesh mould_;
  palpate::Vector3 place_, out_;  // in the frame Jelly: on the surface, and the way out of it
  Doing doing_ = Doing::watching;
  palpate::scene::Quintic path_;
  double begin_ = 0.0;
  palpate::scene::HandTrajectory hand_;
};

}  // namespace jelly
