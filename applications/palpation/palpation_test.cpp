// Palpation in a test: the application, a soft hand, and a trainee that feels late. The hand is a mass on a spring that
// the organ pushes back, and knows nothing of the trainee's plans. The organ is coarse, so that it is ready in seconds.
#include "applications/palpation/palpation.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <memory>

#include "applications/palpation/organ_for_tests.h"
#include "applications/palpation/record.h"
#include "applications/palpation/scene_view.h"
#include "applications/palpation/specification.h"
#include "applications/palpation/trainee.h"
#include "tests/allocation_count.h"

namespace palpate::applications::palpation {
namespace {

// One nodule that everybody feels, in a liver of few vertices.
scene::SceneDescription easy_scene() {
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

// The organ is the same for all tests below and prepared once.
PalpationApplication& easy_application() {
  static PalpationApplication application(easy_scene(), {.seed = 3}, {});
  application.control(scene::Control::reset);
  return application;
}

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

Vector3 in_world(const PalpationApplication& application, const Vector3& body) {
  return (application.rest() * Point<Body>{body}).m;
}

TEST(Palpation, APressIsFeltDentsTheSurfaceAndAllocatesNothing) {
  auto& application = easy_application();
  const auto at_rest = std::vector<float>(application.shape().begin(), application.shape().end());
  ASSERT_EQ(at_rest.size(), liver_mesh(11).vertices.size() * scene::Shape::kFloatsPerVertex);
  const Vector3 top(0.01, 0.0502, 0.0);
  SoftHand hand(application, in_world(application, top + Vector3(0.0, 0.03, 0.0)));
  hand.go_to(hand.x, 0.05);
  EXPECT_EQ(hand.state.counters[kForceMn], 0);
  const std::size_t before = allocations();
  hand.go_to(in_world(application, top), 0.5);
  hand.go_to(in_world(application, top), 0.3);
  EXPECT_EQ(allocations() - before, 0u);
  EXPECT_GT(hand.state.counters[kForceMn], 100);
  EXPECT_GT(hand.state.counters[kDepthUm], 2000);
  EXPECT_EQ(hand.state.counters[kTouches], 1);
  EXPECT_GT(hand.force.dot(application.rest().rotation * Vector3::UnitY()), 0.1) << "it pushes back";
  EXPECT_EQ(hand.state.counters[kNoduleSeed], 0) << "nobody is told while the search goes on";
  double deepest = 0.0;
  for (std::size_t i = 0; i < at_rest.size(); i += 6)
    deepest = std::max(deepest, static_cast<double>(at_rest[i + 1] - application.shape()[i + 1]));
  EXPECT_NEAR(deepest, 1e-6 * hand.state.counters[kDepthUm], 0.0015) << "the dent is as deep as the tip";
  hand.go_to(hand.x + Vector3(0.0, 0.03, 0.0), 0.3);
  EXPECT_TRUE(std::equal(at_rest.begin(), at_rest.end(), application.shape().begin(), [](float a, float b) {
    return std::abs(a - b) < 1e-6f;
  })) << "it comes back";
}

TEST(Palpation, InAPauseNothingIsFeltAndNoTimePasses) {
  auto& application = easy_application();
  const Vector3 top(0.01, 0.0502, 0.0);
  SoftHand hand(application, in_world(application, top + Vector3(0.0, 0.03, 0.0)));
  hand.go_to(hand.x, 0.05);
  application.control(scene::Control::pause);
  hand.go_to(in_world(application, top), 0.4);
  EXPECT_EQ(hand.state.counters[kForceMn], 0);
  EXPECT_EQ(hand.state.counters[kSearchMs], 0);
  application.control(scene::Control::resume);
}

TEST(Palpation, WhatIsHiddenIsToldWhenTheSearchIsOver) {
  auto& application = easy_application();
  const scene::SceneDescription scene = easy_scene();
  PalpationView view(scene);
  PalpationRecord record(scene);
  const HiddenNodule& truth = application.prepared().nodules.at(0);
  const Vector3 over = truth.above + Vector3(0.0, 0.03, 0.0),
                pressed = truth.above + Vector3(0.0, 0.001, 0.0);
  SoftHand hand(application, in_world(application, over));
  hand.go_to(hand.x, 0.05);
  hand.go_to(in_world(application, pressed), 0.4);
  hand.go_to(in_world(application, pressed), 1.4);
  EXPECT_EQ(hand.state.counters[kMarks], 1);
  record.add_state(hand.state);
  EXPECT_TRUE(record.summary()["palpation"]["nodules"].is_null());
  const auto before = view.draw(hand.state).size();
  hand.go_to(in_world(application, over), 0.3);
  application.control(scene::Control::begin);
  hand.go_to(in_world(application, over), 0.01);
  record.add_state(hand.state);
  const Json told = record.summary()["palpation"];
  EXPECT_EQ(told["nodules"], 1);
  EXPECT_EQ(told["found"], 1);
  EXPECT_EQ(told["false_alarms"], 0);
  EXPECT_LT(told["position_error_mm_median"].get<double>(), 4.0);
  const auto items = view.draw(hand.state);
  EXPECT_EQ(items.size(), before + 1) << "the nodule is seen";
  EXPECT_LT((marks_of(hand.state).at(0) - truth.above).norm(), 0.004);
}

struct Search {
  int found = -1, marks = 0;
  double seconds = 0.0, hardest = 0.0;
};

Search search(const scene::SceneDescription& scene, std::uint64_t seed) {
  auto& application = easy_application();
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

TEST(Trainee, FeelsTheNoduleMarksItAndPutsTheStylusAway) {
  for (const std::uint64_t seed : {1u, 2u}) {
    const Search s = search(easy_scene(), seed);
    EXPECT_EQ(s.found, 1) << seed;
    EXPECT_EQ(s.marks, 1);
    EXPECT_LT(s.seconds, 45.0);
    EXPECT_LT(s.hardest, 3.0);
  }
}

TEST(Trainee, WithoutItsSenseItMarksByLot) {
  const auto numb = with(easy_scene(), "palpation.trainee_senses", std::string("no"));
  int found = 0;
  for (const std::uint64_t seed : {1u, 2u, 3u, 4u}) {
    const Search s = search(numb, seed);
    EXPECT_EQ(s.marks, 1);
    found += s.found;
  }
  EXPECT_LE(found, 2);
}

TEST(Palpation, TellsARegistryOfItself) {
  const scene::ApplicationRegistry registry{specification()};
  const auto scene = registry.describe("palpation", registry.settings());
  ASSERT_TRUE(scene) << scene.error().message;
  EXPECT_EQ(scene->bodies.at(scene::kCarried).name, "Stylus");
}

}  // namespace
}  // namespace palpate::applications::palpation
