// For tests: palpation with a nodule that everybody feels, a soft hand that plays it, and a trainee's search with that hand. The
// organ is coarse, so that it is ready in seconds.
#pragma once

#include <algorithm>
#include <filesystem>
#include <memory>
#include <utility>
#include <vector>

#include "applications/palpation/organ_for_tests.h"
#include "applications/palpation/palpation.h"
#include "applications/palpation/trainee.h"
#include "tests/scratch_folder.h"

namespace palpate::applications::palpation {

// One nodule that everybody feels, in a liver of few vertices.
inline scene::SceneDescription easy_scene() {
  static const auto organ = std::make_shared<scene::TriangleMesh>(liver_mesh(11));
  auto scene = table_for_tests();
  for (const auto& [name, value] : std::initializer_list<std::pair<const char*, std::vector<double>>>{
           {"palpation.nodules", {1.0, 1.0}},
           {"palpation.nodule_mm", {19.0, 20.0}},
           {"palpation.nodule_depth_mm", {3.0, 3.5}},
           {"palpation.nodule_ratio", {20.0, 20.0}},
           {"palpation.element_mm", {16.0}},
           {"palpation.trainee_weber", {0.05}}})
    scene = with(std::move(scene), name, value);
  scene.mesh = scene::MeshAsset{.mesh = organ};
  return scene;
}

// Of organs, for all tests of one run of the program.
inline std::filesystem::path cache_for_tests() {
  static const ScratchFolder folder;
  return folder.path();
}

// A mass on a spring that the organ pushes back.
struct SoftHand {
  static constexpr double kTick = 1e-3, kMass = 0.225, kStiffness = 250.0, kDamping = 4.0;
  PalpationApplication& application;
  scene::SceneState state;
  scene::TipState tip;
  Vector3 x, v = Vector3::Zero(), force = Vector3::Zero();
  int ticks = 0;

  SoftHand(PalpationApplication& played, const Vector3& start) : application(played), x(start) {}
  Instant<PhysicsClock> now() const { return Instant<PhysicsClock>::from_seconds(10.0 + ticks * kTick); }
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
    force = application.contact_law()->force(tip, kTick);  // as the haptic tick does
    application.step(now(), seconds(kTick), tip, state);
    state.time = now();
  }
  void go_to(const Vector3& place, double for_s) {
    const Vector3 from = x;
    const int steps = static_cast<int>(for_s / kTick);
    for (int i = 1; i <= steps; ++i) follow({{from + (place - from) * i / steps}, Vector3::Zero(), {}});
  }
};

inline Vector3 in_world(const PalpationApplication& application, const Vector3& body) {
  return (application.rest() * Point<Body>{body}).m;
}

struct Search {
  int found = -1, marks = 0;
  double seconds = 0.0, hardest = 0.0;
};

// The trainee of a scene plays an application, which need not be that scene's, until the search is over.
inline Search search(PalpationApplication& application, const scene::SceneDescription& scene,
                     std::uint64_t seed) {
  scene::Reach reach;
  reach.X_world_base = {rotation_from_xyz({0.0262, -0.0698, 0.0140}), {0.10, -1.40, 1.75}};
  scene::PlayerSettings settings;
  settings.seed = seed;
  settings.hand = {.stiffness = SoftHand::kStiffness / SoftHand::kMass,
                   .damping = SoftHand::kDamping / SoftHand::kMass};
  Trainee trainee(scene, reach, settings);
  SoftHand hand(application, reach.home());
  Search result;
  for (int i = 0; i < 80'000 && application.trial().phase() != TrialPhase::shown; ++i) {
    if (i % 33 == 0) trainee.show(hand.state, hand.now() + seconds(0.05));
    hand.follow(trainee.act(hand.now()));
    result.hardest = std::max(result.hardest, hand.force.norm());
  }
  hand.go_to(hand.x, 0.01);
  result.found = hand.state.counters[kFound];
  result.marks = hand.state.counters[kMarks];
  result.seconds = 1e-3 * hand.state.counters[kSearchMs];
  return result;
}

}  // namespace palpate::applications::palpation
