// Palpation by staircase: trial after trial, each as hard as what was found before makes it, told in the state, kept in a
// file, and the same when what its loops learned is played back.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <thread>
#include <vector>

#include "applications/palpation/hand_for_tests.h"
#include "applications/palpation/learning_file.h"
#include "applications/palpation/palpation.h"
#include "applications/palpation/record.h"
#include "applications/palpation/scene_view.h"
#include "palpate/core/file.h"
#include "palpate/time/input_playback.h"
#include "palpate/time/input_trace.h"
#include "tests/scratch_folder.h"

namespace palpate::applications::palpation {
namespace {

scene::SceneDescription scene_by_staircase(const std::filesystem::path& file) {
  return with(with(easy_scene(), "palpation.difficulty", std::string("staircase")), "palpation.learning_file",
              file.string());
}

// Once the search is over: asks for the next trial until it is there.
void go_on(SoftHand& hand) {
  constexpr int kMostLooks = 20'000;
  const auto number = hand.state.counters[kTrial];
  hand.application.control(scene::Control::begin);
  for (int i = 0; i < kMostLooks && hand.state.counters[kTrial] == number; ++i) {
    go_to(hand, hand.x, 0.001);
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
  ASSERT_EQ(hand.state.counters[kTrial], number + 1);
}

// The upper side's place in the middle of the half without the nodule.
Vector3 elsewhere(const PalpationApplication& application, const scene::TriangleMesh& organ) {
  const double x = application.prepared().nodules.at(0).above.x() > 0.0 ? -0.02 : 0.02;
  const auto aside = [x](const Vector3& v) {
    return std::hypot(v.x() - x, v.z()) + (v.y() > 0.02 ? 0.0 : 1.0);
  };
  return *std::min_element(organ.vertices.begin(), organ.vertices.end(),
                           [&](const Vector3& a, const Vector3& b) { return aside(a) < aside(b); });
}

// Presses there, marks it and asks for the end.
void search_at(SoftHand& hand, const Vector3& place) {
  const auto& application = hand.application;
  const Vector3 over = place + Vector3(0.0, 0.03, 0.0);
  go_to(hand, in_world(application, over), 0.4);
  go_to(hand, in_world(application, place + Vector3(0.0, 0.001, 0.0)), 0.3);
  go_to(hand, in_world(application, place + Vector3(0.0, 0.001, 0.0)), 1.4);
  go_to(hand, in_world(application, over), 0.3);
  hand.application.control(scene::Control::begin);
  go_to(hand, hand.x, 0.002);
  ASSERT_EQ(application.trial().phase(), TrialPhase::shown);
}

std::string captions_of(const scene::SceneDescription& scene, const scene::SceneState& state) {
  std::string all;
  for (const auto& line : PalpationView(scene).captions(state)) all += line + "\n";
  return all;
}

TEST(PalpationByStaircase, ATraineeWhoFindsIsLedUpAndOneWithoutItsSenseDown) {
  const ScratchFolder folder;
  const auto file = folder / "me.csv";
  const auto scene = scene_by_staircase(file);
  const auto numb = with(scene, "palpation.trainee_senses", std::string("no"));
  {
    PalpationApplication application(scene, {.seed = 3}, cache_for_tests());
    SoftHand hand(application, in_world(application, {0.0, 0.15, 0.0}));
    std::vector<int> levels;
    for (int trial = 1; trial <= 4; ++trial) {
      go_to(hand, hand.x, 0.002);
      levels.push_back(level_told(palpation_settings(scene), hand.state).value_or(-1));
      EXPECT_NE(captions_of(scene, hand.state).find(fmt::format("level {}", levels.back())),
                std::string::npos);
      if (trial == 4) break;
      const Search done = search(application, trial <= 2 ? scene : numb, static_cast<std::uint64_t>(trial));
      EXPECT_EQ(done.found, trial <= 2 ? 1 : 0) << "the numb one marks by lot; choose another seed";
      go_to(hand, hand.x, 0.002);
      go_on(hand);
    }
    EXPECT_EQ(levels, (std::vector<int>{3, 3, 5, 4}));
    const auto& now = application.prepared().nodules.at(0).ball;
    EXPECT_NEAR(now.radius, 0.5 * 0.0196, 1e-12) << "20 mm less four tenths of the way to 19";
  }
  const auto lines = read_learning(file).value();
  ASSERT_EQ(lines.size(), 3u);
  EXPECT_EQ(lines[2].level, 5);
  EXPECT_EQ(lines[0].found, 1);
  EXPECT_GT(lines[0].seconds, 5.0);
  EXPECT_GT(lines[0].path, 0.3);
  EXPECT_GT(lines[0].peak_force, 0.1);
}

TEST(PalpationByStaircase, WhoIsToldTheStateDrawsTheSameNodulesAndTellsTheLevel) {
  const ScratchFolder folder;
  const auto scene = with(scene_by_staircase(folder / "me.csv"), "palpation.level", std::vector<double>{8.0});
  PalpationApplication application(scene, {.seed = 3}, cache_for_tests());
  SoftHand hand(application, in_world(application, {0.0, 0.15, 0.0}));
  go_to(hand, hand.x, 0.002);
  EXPECT_EQ(hand.state.counters[kNoduleSeed], -9) << "the level, and nothing of where they are";
  RevealedNodules revealed(pressed_mesh(scene), palpation_settings(scene));
  EXPECT_TRUE(revealed.of(hand.state).empty());
  search_at(hand, application.prepared().nodules.at(0).above);
  const auto& told = revealed.of(hand.state);
  const auto& truth = application.prepared().nodules;
  ASSERT_EQ(told.size(), truth.size());
  EXPECT_EQ(told[0].ball.centre, truth[0].ball.centre);
  EXPECT_EQ(told[0].ball.radius, truth[0].ball.radius);
  PalpationRecord record(scene);
  record.add_state(hand.state);
  const Json summary = record.summary();
  EXPECT_EQ(summary["palpation"]["level"], 8);
  EXPECT_NE(record.closing_lines(summary)[0].text.find("found 1 of 1 nodules at level 8,"),
            std::string::npos);
  Json untouched = summary;
  untouched["palpation"]["over"] = false, untouched["palpation"]["seconds"] = 0.0;
  EXPECT_EQ(record.closing_lines(untouched)[0].text,
            "the search at level 8 was not begun: the organ was never touched");
  EXPECT_NE(captions_of(scene, hand.state).find("Space: the next trial"), std::string::npos);
  // What a trial that has just begun counts is not this one's.
  auto next = hand.state;
  next.counters[kTrial] += 1, next.counters[kNoduleSeed] = -9, next.counters[kTouches] += 70;
  record.add_state(next);
  EXPECT_EQ(record.summary()["palpation"]["presses"], summary["palpation"]["presses"]);
  EXPECT_EQ(record.summary()["palpation"]["trial"], summary["palpation"]["trial"]);
  // A reset lets the same be searched again, by somebody who has seen where the nodules are: it counts once.
  application.control(scene::Control::reset);
  search_at(hand, elsewhere(application, pressed_mesh(scene)));
  go_on(hand);
  EXPECT_EQ(hand.state.counters[kNoduleSeed], -9) << "one search that found all: neither up nor down";
  EXPECT_EQ(read_learning(folder / "me.csv")->size(), 1u);
}

TEST(PalpationByStaircase, LevelsThatDoNotFitAreRefusedAtTheStart) {
  const auto scene =
      with(scene_by_staircase({}), "palpation.nodule_depth_mm", std::vector<double>{3.0, 30.0});
  try {
    PalpationApplication application(scene, {.seed = 3}, {});
    FAIL() << "nodules of 19 mm, 30 mm deep";
  } catch (const std::runtime_error& refusal) {
    EXPECT_NE(std::string(refusal.what()).find("do not fit"), std::string::npos) << refusal.what();
    EXPECT_NE(std::string(refusal.what()).find("level 10"), std::string::npos) << refusal.what();
  }
}

// Ticks of both loops in one thread: where the tip was, what the tick learned, the state that came out.
struct Session {
  std::vector<Vector3> places;
  std::vector<std::vector<std::uint64_t>> learned;
  std::vector<scene::SceneState> states;
  std::size_t asked = 0;  // the tick before which the next trial was asked for
};

// One tick, with the trace in hand.
void tick(PalpationApplication& application, InputTrace& trace, std::size_t number, const Vector3& place,
          scene::SceneState& state) {
  constexpr double kTick = 1e-3;
  scene::TipState tip;
  tip.time = Instant<PhysicsClock>::from_seconds(10.0 + static_cast<double>(number) * kTick);
  tip.X_world_tip.translation = place;
  const InputTrace::Scope scope(&trace);
  application.contact_law()->force(tip, kTick);
  application.step(tip.time, seconds(kTick), tip, state);
}

void record_tick(PalpationApplication& application, const Vector3& place, Session& session) {
  scene::SceneState state = session.states.empty() ? scene::SceneState{} : session.states.back();
  InputTrace trace;
  trace.write();
  tick(application, trace, session.states.size(), place, state);
  session.places.push_back(place);
  session.learned.emplace_back(trace.values().begin(), trace.values().end());
  session.states.push_back(state);
}

// Down onto the organ, held there for longer than a mark takes, and put away.
constexpr int kSearchTicks = 2600;
Vector3 place_at(int of_search) {
  const double down = std::max(0.050, 0.080 - 1e-4 * of_search);
  return {0.01, of_search < 1600 ? down : 0.12, 0.0};
}

// Two trials by staircase, into a file.
Session record_session(const scene::SceneDescription& scene) {
  PalpationApplication application(scene, {.seed = 3}, cache_for_tests());
  Session session;
  const auto search = [&] {
    for (int i = 0; i < kSearchTicks; ++i)
      record_tick(application, in_world(application, place_at(i)), session);
    EXPECT_EQ(application.trial().phase(), TrialPhase::shown);
  };
  search();
  session.asked = session.states.size();
  application.control(scene::Control::begin);
  for (int i = 0; i < 20'000 && session.states.back().counters[kTrial] == 1; ++i) {
    record_tick(application, session.places.back(), session);
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
  EXPECT_EQ(session.states.back().counters[kTrial], 2);
  search();
  return session;
}

TEST(PalpationByStaircase, ASessionOfTwoTrialsIsExecutedAgainAndItsFileIsLeftAlone) {
  const ScratchFolder folder;
  const auto file = folder / "me.csv";
  const auto scene = scene_by_staircase(file);
  const Session session = record_session(scene);
  EXPECT_EQ(read_learning(file)->size(), 2u);
  std::filesystem::remove(file);

  InputPlayback playback(1);
  InputTrace making;
  making.play({}, playback);
  const InputTrace::Scope scope(&making);
  PalpationApplication again(scene, {.seed = 3, .keeps_files = false}, cache_for_tests());
  scene::SceneState state;
  for (std::size_t i = 0; i < session.states.size(); ++i) {
    if (i == session.asked) again.control(scene::Control::begin);
    InputTrace trace;
    trace.play(session.learned[i], playback);
    tick(again, trace, i, session.places[i], state);
    ASSERT_TRUE(trace.exact() && !playback.failed()) << "tick " << i;
    ASSERT_EQ(state.counters, session.states[i].counters) << "tick " << i;
    ASSERT_EQ(state.continuous.force, session.states[i].continuous.force) << "tick " << i;
  }
  EXPECT_EQ(state.counters[kTrial], 2);
  EXPECT_FALSE(is_there(file));
}

}  // namespace
}  // namespace palpate::applications::palpation
