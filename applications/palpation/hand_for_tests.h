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
#include "palpate/scene/soft_hand_for_tests.h"
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

using SoftHand = scene::SoftHand<PalpationApplication>;

// To a place in so many seconds, in a straight line.
inline void go_to(SoftHand& hand, const Vector3& place, double for_s) {
  const Vector3 from = hand.x;
  const int steps = static_cast<int>(for_s / SoftHand::kTick);
  for (int i = 1; i <= steps; ++i) hand.follow({{from + (place - from) * i / steps}, Vector3::Zero(), {}});
}

inline Vector3 in_world(const PalpationApplication& application, const Vector3& body) {
  return (application.rest() * Point<Body>{body}).m;
}

struct Search {
  int found = -1, marks = 0;
  double seconds = 0.0, hardest = 0.0;
};

// The trainee of a scene plays an application, which need not be that scene's, search after search.
class SearchingHand {
 public:
  SearchingHand(PalpationApplication& application, const scene::SceneDescription& scene, std::uint64_t seed)
      : application_(application),
        trainee_(scene, reach_, SoftHand::player_settings(seed)),
        hand_(application, reach_.home()) {}

  void step() {
    if (ticks_++ % 33 == 0) trainee_.show(hand_.state, hand_.now() + seconds(0.05));
    hand_.follow(trainee_.act(hand_.now()));
  }

  // Until the search is over.
  Search search() {
    Search result;
    for (int i = 0; i < 80'000 && application_.trial().phase() != TrialPhase::shown; ++i) {
      step();
      result.hardest = std::max(result.hardest, hand_.force.norm());
    }
    go_to(hand_, hand_.x, 0.01);
    result.found = hand_.state.counters[kFound];
    result.marks = hand_.state.counters[kMarks];
    result.seconds = 1e-3 * hand_.state.counters[kSearchMs];
    return result;
  }

  int trial() const { return hand_.state.counters[kTrial]; }

 private:
  PalpationApplication& application_;
  const scene::Reach reach_ = SoftHand::reach();
  Trainee trainee_;
  SoftHand hand_;
  int ticks_ = 0;
};

inline Search search(PalpationApplication& application, const scene::SceneDescription& scene,
                     std::uint64_t seed) {
  return SearchingHand(application, scene, seed).search();
}

}  // namespace palpate::applications::palpation
