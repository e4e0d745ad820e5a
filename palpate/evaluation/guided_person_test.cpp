// A session with a person who is told what to do and seen in the devices' streams alone; the laboratory's person sits
// before the panel.
#include "palpate/calibration/session/guided_person.h"

#include <gtest/gtest.h>

#include <deque>

#include "palpate/calibration/session/calibration_session.h"
#include "palpate/calibration/session/landmark_finder.h"
#include "palpate/evaluation/world_sample.h"
#include "palpate/sim/camera_renderer.h"

namespace palpate::evaluation {
namespace {

using namespace calibration::session;

// Does what is shown and presses the key when it is done.
class SimulatedReader : public Panel {
 public:
  explicit SimulatedReader(device::Person& person) : person_(person) {}

  void show(const device::Request& request, const std::string& text) override {
    EXPECT_FALSE(text.empty());
    shown.push_back(request);
    pressed_ = false;
    const auto asked = person_.ask(request);
    refusal_ = asked ? ErrorCode::unspecified : asked.error().code;
  }
  void tell(const std::string& line) override { told.push_back(line); }
  void observe(const PersonView& view) override { observed.push_back(view); }
  void released() override { EXPECT_TRUE(person_.release()); }
  void taken() override { ++sounds; }
  std::optional<PanelKey> key() override {
    if (stop_at >= 0 && static_cast<int>(shown.size()) > stop_at) return PanelKey::stop;
    const ErrorCode refusal = std::exchange(refusal_, ErrorCode::unspecified);
    if (refusal == ErrorCode::no_more) return PanelKey::no_more;
    if (refusal == ErrorCode::out_of_reach) return PanelKey::skip;
    if (pressed_ || !*person_.ready()) return std::nullopt;
    pressed_ = true;
    return PanelKey::proceed;
  }

  std::deque<device::Request> shown;
  std::deque<std::string> told;
  std::deque<PersonView> observed;
  int sounds = 0, stop_at = -1;

 private:
  device::Person& person_;
  bool pressed_ = false;
  ErrorCode refusal_ = ErrorCode::unspecified;
};

// Keys as they are pressed.
class TypedKeys : public Panel {
 public:
  void show(const device::Request&, const std::string& text) override {
    ++shown;
    last = text;
  }
  void tell(const std::string&) override {}
  void taken() override {}
  std::optional<PanelKey> key() override {
    if (keys.empty()) return std::nullopt;
    const PanelKey first = keys.front();
    keys.pop_front();
    return first;
  }
  std::deque<PanelKey> keys;
  int shown = 0;
  std::string last;
};

TEST(GuidedPerson, APlaceThatIsTouchedAgainIsAskedForOnceMore) {
  TypedKeys panel;
  GuidedPerson person(panel);
  ASSERT_TRUE(person.ask({device::Gesture::touch, "table", 1}));
  EXPECT_EQ(panel.last, "Hold the pointer's tip on corner 2 of the table and press Enter.");
  ASSERT_TRUE(person.ask({device::Gesture::touch, "wall", 1}));
  EXPECT_EQ(panel.last, "Hold the pointer's tip on corner 2 of the wall and press Enter.");
  ASSERT_TRUE(person.ask({device::Gesture::touch, "table", 1}));
  EXPECT_EQ(panel.last, "Once more: hold the pointer's tip on corner 2 of the table and press Enter.");
}

TEST(GuidedPerson, APoseThatIsShownIsToldInNumbers) {
  TypedKeys panel;
  GuidedPerson person(panel);
  device::Request request{device::Gesture::next_pose, "", 0};
  request.target.emplace();
  request.target->tip = {Vector3(0.12, -1.4, 1.75)};
  ASSERT_TRUE(person.ask(request));
  EXPECT_NE(panel.last.find("(120, -1400, 1750) mm in World"), std::string::npos) << panel.last;
}

TEST(GuidedPerson, OfKnownLandmarksThereAreNotNoMore) {
  TypedKeys panel;
  GuidedPerson person(panel);
  panel.keys = {};
  ASSERT_TRUE(person.ask({device::Gesture::touch, "landmark", 3, {}, true}));
  panel.keys = {PanelKey::no_more};
  const auto known = person.ready();
  ASSERT_TRUE(known) << known.error().message;
  EXPECT_FALSE(*known);
  ASSERT_TRUE(person.ask({device::Gesture::touch, "landmark", 3}));
  panel.keys = {PanelKey::no_more};
  const auto unknown = person.ready();
  ASSERT_FALSE(unknown);
  EXPECT_EQ(unknown.error().code, ErrorCode::no_more);
}

TEST(GuidedPerson, WhatWasPressedBeforeAQuestionAnswersNoneButAStop) {
  TypedKeys panel;
  GuidedPerson person(panel);
  panel.keys = {PanelKey::proceed, PanelKey::no_more};
  ASSERT_TRUE(person.ask({device::Gesture::hold, "", 0}));
  EXPECT_FALSE(*person.ready());
  panel.keys = {PanelKey::proceed};
  EXPECT_TRUE(*person.ready());
  ASSERT_TRUE(person.ask({device::Gesture::hold, "", 0}));
  panel.keys = {PanelKey::no_more};
  const auto not_today = person.ready();
  ASSERT_FALSE(not_today);
  EXPECT_EQ(not_today.error().code, ErrorCode::no_more);
  panel.keys = {PanelKey::proceed, PanelKey::stop};
  const auto stopped = person.ask({device::Gesture::hold, "", 0});
  ASSERT_FALSE(stopped);
  EXPECT_EQ(stopped.error().code, ErrorCode::stopped);
}

// Who is asked presses a key some time; where nobody waits for it, it would answer what comes next.
TEST(GuidedPerson, IsAskedForNothingThatNobodyWaitsFor) {
  TypedKeys panel;
  GuidedPerson person(panel);
  ASSERT_TRUE(person.ask({device::Gesture::next_pose, "", 0}));
  ASSERT_TRUE(person.release());
  EXPECT_EQ(panel.shown, 1);
}

struct GuidedSession : ::testing::Test {
  sim::config::WorldFile file = sim::config::reference_world();
  sim::CameraRenderer renderer;
  sim::Simulator world{file, 9};
  SimulatedReader reader{world.person()};
  GuidedPerson person{reader};
  rig::Rig rig = blank_rig(file);
  CalibrationPlan plan;
  SessionHooks hooks;
  std::vector<StepOutcome> outcomes;

  GuidedSession() {
    world.set_renderer(
        [this](const sim::TrueView& view, std::vector<std::uint8_t>& rgb) { renderer.render(view, rgb); });
    plan.corner_rounds = 1;
    plan.pivot_poses = 60;
    plan.pivot_s = 6.0;
    plan.arm_points = plan.arm_test_points = 20;
    plan.moving_s = 3.0;
    plan.board_s = 5.0;
    plan.board_every = 4;
    plan.lens_views = 15;
    plan.look_s = 1.0;
    plan.reach = reach_of(file);
    hooks.find_landmarks = landmark_finder();
  }

  AcquisitionContext devices() {
    AcquisitionContext context = laboratory_of(world);
    return {context.clock, context.arm, context.tracker, context.camera, person, context.right_camera, true};
  }

  void go_on_with_everything() {
    hooks.review = [this](const StepOutcome& outcome) {
      outcomes.push_back(outcome);
      return Review::go_on;
    };
  }
};

TEST_F(GuidedSession, EndsAtARigLikeThatOfThePersonWhoActs) {
  go_on_with_everything();
  const auto done = calibrate_rig(devices(), rig, plan, hooks);
  ASSERT_TRUE(done) << done.error().message;
  ASSERT_EQ(outcomes.size(), 8u);
  for (const auto& outcome : outcomes) EXPECT_TRUE(outcome.done && !outcome.words.empty()) << outcome.step;
  EXPECT_EQ(rig.landmarks.size(), world.truth().landmarks.size()) << "n ended the landmarks";
  EXPECT_LT(rig.arm->held_out_mean, 0.5e-3);
  EXPECT_LT((rig.pointer_pivot->tip_in_marker - world.truth().pointer_tip).norm(), 0.5e-3);
  EXPECT_GE(reader.sounds, 2 * plan.arm_points + 8) << "one for each pose and touch";
  bool led = false;
  for (const auto& line : reader.told) led = led || line.find("turn it by") != std::string::npos;
  EXPECT_TRUE(led) << "where to go was told";
}

TEST_F(GuidedSession, APanelThatDrawsSeesTheMarkersTwentyTimesASecond) {
  hooks.review = [](const StepOutcome&) { return Review::stop; };
  const double began = world.physics_clock().now().seconds();
  ASSERT_FALSE(calibrate_rig(devices(), rig, plan, hooks));
  ASSERT_GT(reader.observed.size(), 20u);
  const double seconds_long = reader.observed.back().now_s - began;
  EXPECT_NEAR(static_cast<double>(reader.observed.size()) / seconds_long, 20.0, 1.0);
  // Of the first step: the pointer is swung.
  int seen = 0, still = 0;
  for (const auto& view : reader.observed) {
    EXPECT_TRUE(view.arm_answers);
    EXPECT_FALSE(view.near_target);
    seen += view.pointer.seen;
    still += view.pointer.seen && view.pointer.still;
  }
  EXPECT_GT(seen, static_cast<int>(reader.observed.size()) / 2);
  EXPECT_LT(still, seen / 2);
  const auto& last = reader.observed.back().pointer;
  EXPECT_GT(last.translation.norm(), 1.0) << "World: the tracker hangs above";
}

TEST_F(GuidedSession, AStepIsRepeatedAndUndoneAsThePersonSays) {
  std::vector<std::pair<std::string, Review>> script{{"pointer tip", Review::repeat},
                                                     {"pointer tip", Review::go_on},
                                                     {"table and wall", Review::undo},
                                                     {"pointer tip", Review::go_on},
                                                     {"table and wall", Review::stop}};
  std::size_t at = 0;
  std::vector<std::pair<bool, bool>> saved;  // pointer, surfaces
  hooks.save = [&](const rig::Rig& now) -> Expected<void> {
    saved.emplace_back(now.pointer_pivot.has_value(), !now.surfaces.empty());
    return {};
  };
  hooks.review = [&](const StepOutcome& outcome) {
    EXPECT_EQ(outcome.step, script[at].first);
    EXPECT_EQ(outcome.first, outcome.step == "pointer tip");
    return script[at++].second;
  };
  const auto done = calibrate_rig(devices(), rig, plan, hooks);
  ASSERT_FALSE(done);
  EXPECT_EQ(done.error().code, ErrorCode::stopped);
  EXPECT_EQ(at, script.size());
  const std::vector<std::pair<bool, bool>> expected{{true, false}, {false, false}, {true, false},
                                                    {true, true},  {false, false}, {true, false},
                                                    {true, true}};
  EXPECT_EQ(saved, expected);
  EXPECT_TRUE(rig.pointer_pivot && rig.surface("wall") != nullptr) << "what is done is kept";
}

TEST_F(GuidedSession, AStepThatFailsMayBeDoneAgain) {
  plan.pivot_poses = 100000;  // more than a tracker shows in that time
  int failures = 0;
  hooks.review = [&](const StepOutcome& outcome) {
    if (outcome.done) return Review::stop;
    EXPECT_NE(outcome.words.find("the tracker saw the marker"), std::string::npos) << outcome.words;
    EXPECT_FALSE(rig.pointer_pivot);
    ++failures;
    plan.pivot_poses = 60;
    return Review::repeat;
  };
  const auto done = calibrate_rig(devices(), rig, plan, hooks);
  ASSERT_FALSE(done);
  EXPECT_EQ(done.error().code, ErrorCode::stopped);
  EXPECT_EQ(failures, 1);
  EXPECT_TRUE(rig.pointer_pivot);
}

TEST_F(GuidedSession, NobodyIsHurriedAndWhoeverBreaksOffKeepsWhatIsDone) {
  go_on_with_everything();
  reader.stop_at = 5;  // among the corners
  const auto done = calibrate_rig(devices(), rig, plan, hooks);
  ASSERT_FALSE(done);
  EXPECT_EQ(done.error().code, ErrorCode::stopped);
  EXPECT_TRUE(rig.pointer_pivot);
  EXPECT_TRUE(rig.surfaces.empty());
  EXPECT_FALSE(person.patience());
}

TEST_F(GuidedSession, AStopEndsARecordingWithinItsTick) {
  std::atomic<bool> stop{false};
  AcquisitionContext context = devices();
  context.stop = &stop;
  hooks.progress = [&](std::size_t step, std::size_t, const std::string&) { stop = step == 1; };
  const auto before = world.now();
  const auto done = calibrate_rig(context, rig, plan, hooks);
  ASSERT_FALSE(done);
  EXPECT_EQ(done.error().code, ErrorCode::stopped);
  EXPECT_TRUE(rig.pointer_pivot);
  EXPECT_LT((world.now() - before).count(), seconds(15.0).count());
}

}  // namespace
}  // namespace palpate::evaluation
