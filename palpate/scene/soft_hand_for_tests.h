// For tests of applications: a mass on a spring that the application's contact law pushes back, and which knows nothing of
// the plans of whoever leads it.
#pragma once

#include "palpate/device/devices.h"
#include "palpate/scene/application.h"
#include "palpate/scene/player.h"

namespace palpate::scene {

template <typename Played>  // an Application
struct SoftHand {
  static constexpr double kTick = 1e-3, kMass = 0.225, kStiffness = 250.0, kDamping = 4.0;
  Played& application;
  SceneState state;
  TipState tip;
  Vector3 x, v = Vector3::Zero(), force = Vector3::Zero();
  int ticks = 0;

  SoftHand(Played& played, const Vector3& start) : application(played), x(start) {}
  // Of the newest tick, and of the one that follow() makes.
  Instant<PhysicsClock> now() const { return Instant<PhysicsClock>::from_seconds(10.0 + ticks * kTick); }
  Instant<PhysicsClock> next() const {
    return Instant<PhysicsClock>::from_seconds(10.0 + (ticks + 1) * kTick);
  }
  // One tick: the hand, the law as the haptic tick asks it, the application's step.
  void follow(const device::HandTarget& target) {
    ++ticks;
    for (int k = 0; k < 4; ++k) {
      v +=
          0.25 * kTick / kMass * (force + kStiffness * (target.tip.m - x) + kDamping * (target.velocity - v));
      x += 0.25 * kTick * v;
    }
    tip.X_world_tip = {target.R_world_tip, x};
    tip.velocity = v;
    tip.time = now();
    force = application.contact_law()->force(tip, kTick);
    application.step(now(), seconds(kTick), tip, state);
    state.time = now();
  }
  // Of a player with this hand, who is where the reference laboratory's is.
  static PlayerSettings player_settings(std::uint64_t seed) {
    PlayerSettings settings;
    settings.seed = seed;
    settings.hand = {.stiffness = kStiffness / kMass, .damping = kDamping / kMass};
    return settings;
  }
  static Reach reach() {
    Reach reach;
    reach.X_world_base = {rotation_from_xyz({0.0262, -0.0698, 0.0140}), {0.10, -1.40, 1.75}};
    return reach;
  }
};

}  // namespace palpate::scene
