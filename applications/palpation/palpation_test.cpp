// Palpation in a test: the application, a soft hand, and a trainee that feels late. The hand is a mass on a spring that
// the organ pushes back, and knows nothing of the trainee's plans. The organ is coarse, so that it is ready in seconds.
#include "applications/palpation/palpation.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <memory>
#include <thread>

#include "applications/palpation/hand_for_tests.h"
#include "applications/palpation/organ_for_tests.h"
#include "applications/palpation/record.h"
#include "applications/palpation/scene_view.h"
#include "applications/palpation/specification.h"
#include "applications/palpation/trainee.h"
#include "tests/allocation_count.h"

namespace palpate::applications::palpation {
namespace {

// The organ is the same for all tests below and prepared once.
PalpationApplication& easy_application() {
  static PalpationApplication application(easy_scene(), {.seed = 3}, cache_for_tests());
  application.control(scene::Control::reset);
  return application;
}

TEST(Palpation, APressIsFeltDentsTheSurfaceAndAllocatesNothing) {
  auto& application = easy_application();
  const auto at_rest = std::vector<float>(application.shape().begin(), application.shape().end());
  ASSERT_EQ(at_rest.size(), liver_mesh(11).vertices.size() * scene::Shape::kFloatsPerVertex);
  const Vector3 top(0.01, 0.0502, 0.0);
  SoftHand hand(application, in_world(application, top + Vector3(0.0, 0.03, 0.0)));
  go_to(hand, hand.x, 0.05);
  EXPECT_EQ(hand.state.counters[kForceMn], 0);
  const std::size_t before = allocations();
  go_to(hand, in_world(application, top), 0.5);
  go_to(hand, in_world(application, top), 0.3);
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
  go_to(hand, hand.x + Vector3(0.0, 0.03, 0.0), 0.3);
  EXPECT_TRUE(std::equal(at_rest.begin(), at_rest.end(), application.shape().begin(), [](float a, float b) {
    return std::abs(a - b) < 1e-6f;
  })) << "it comes back";
}

// In a session of its own: the first time that a trial is over, its search is handed to the thread that prepares trials.
TEST(Palpation, TheEndOfASearchAllocatesNothing) {
  PalpationApplication application(easy_scene(), {.seed = 3}, cache_for_tests());
  const Vector3 top(0.01, 0.0502, 0.0);
  SoftHand hand(application, in_world(application, top + Vector3(0.0, 0.03, 0.0)));
  go_to(hand, in_world(application, top), 0.3);
  ASSERT_EQ(application.trial().phase(), TrialPhase::searching);
  go_to(hand, in_world(application, top + Vector3(0.0, 0.03, 0.0)), 0.2);
  const std::size_t before = allocations();
  application.control(scene::Control::begin);
  go_to(hand, hand.x, 0.003);
  const std::size_t after = allocations();
  EXPECT_EQ(application.trial().phase(), TrialPhase::shown);
  EXPECT_EQ(after - before, 0u);
}

TEST(Palpation, InAPauseNothingIsFeltAndNoTimePasses) {
  auto& application = easy_application();
  const Vector3 top(0.01, 0.0502, 0.0);
  SoftHand hand(application, in_world(application, top + Vector3(0.0, 0.03, 0.0)));
  go_to(hand, hand.x, 0.05);
  application.control(scene::Control::pause);
  go_to(hand, in_world(application, top), 0.4);
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
  go_to(hand, hand.x, 0.05);
  go_to(hand, in_world(application, pressed), 0.4);
  go_to(hand, in_world(application, pressed), 1.4);
  EXPECT_EQ(hand.state.counters[kMarks], 1);
  record.add_state(hand.state);
  EXPECT_TRUE(record.summary()["palpation"]["nodules"].is_null());
  const auto before = view.draw(hand.state).size();
  go_to(hand, in_world(application, over), 0.3);
  application.control(scene::Control::begin);
  go_to(hand, in_world(application, over), 0.01);
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

TEST(Trainee, FeelsTheNoduleMarksItAndPutsTheStylusAway) {
  for (const std::uint64_t seed : {1u, 2u}) {
    const Search s = search(easy_application(), easy_scene(), seed);
    EXPECT_EQ(s.found, 1) << seed;
    EXPECT_EQ(s.marks, 1);
    EXPECT_LT(s.seconds, 45.0);
    EXPECT_LT(s.hardest, 3.0);
  }
}

TEST(Trainee, SearchesAgainInTheNextTrialAndAfterAReset) {
  PalpationApplication application(easy_scene(), {.seed = 3}, cache_for_tests());
  SearchingHand hand(application, easy_scene(), 1);
  EXPECT_EQ(hand.search().found, 1);
  application.control(scene::Control::begin);
  constexpr int kPatience = 60000;  // steps: the next organ is prepared in a thread of its own
  for (int i = 0; i < kPatience && hand.trial() == 1; ++i) {
    hand.step();
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
  ASSERT_EQ(hand.trial(), 2);
  EXPECT_EQ(hand.search().found, 1) << "another nodule, elsewhere";
  application.control(scene::Control::reset);
  hand.step();
  const Search again = hand.search();
  EXPECT_EQ(hand.trial(), 2);
  EXPECT_EQ(again.found, 1);
  EXPECT_GT(again.seconds, 1.0);
}

TEST(Trainee, WithoutItsSenseItMarksByLot) {
  const auto numb = with(easy_scene(), "palpation.trainee_senses", std::string("no"));
  int found = 0;
  for (const std::uint64_t seed : {1u, 2u, 3u, 4u}) {
    const Search s = search(easy_application(), numb, seed);
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
