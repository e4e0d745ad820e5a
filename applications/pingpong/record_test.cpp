#include "applications/pingpong/record.h"

#include <gtest/gtest.h>

#include "applications/pingpong/pingpong.h"
#include "applications/pingpong/scene_for_tests.h"

namespace palpate::applications::pingpong {
namespace {

const Vector3 kBehindBat(0.0, 0.05, 0.8), kBeside(0.2, 0.0, 0.8), kInFront(0.0, 0.05, 0.4);

// The camera looks along +z from the origin; the bat faces it half a metre away.
scene::SceneState state_with(const Vector3& ball) {
  scene::SceneState state;
  state.body_count = 2;
  state.bodies[kBall].set_p(ball);
  state.bodies[kBat].set_p({0.0, 0.0, 0.5});
  state.bodies[kBat].set_q(rotation_between(Vector3::UnitY(), Vector3::UnitZ()));
  return state;
}

scene::Highlight seen(const scene::SceneState& state, const scene::SceneDescription& scene = {},
                      bool have_state = true) {
  const device::CameraModel lens{.width = 64, .height = 48, .fx = 56.0, .fy = 56.0, .cx = 32.0, .cy = 24.0};
  return GameRecord(scene).highlight(
      {.state = state, .have_state = have_state, .lens = lens, .X_world_camera = {}});
}

TEST(BallInSight, HiddenOnlyBehindTheBatOrOutOfThePicture) {
  EXPECT_FALSE(seen(state_with(kBehindBat)).in_sight);
  EXPECT_TRUE(seen(state_with(kBeside)).in_sight);
  EXPECT_TRUE(seen(state_with(kInFront)).in_sight);
  EXPECT_FALSE(seen(state_with({2.0, 0.0, 0.8})).in_sight);
  EXPECT_FALSE(seen(state_with({0.0, 0.0, -0.8})).in_sight);
  EXPECT_FALSE(seen(state_with(kBeside), {}, false).in_sight);
  auto without_bat = state_with(kBehindBat);
  without_bat.bodies[kBat].visible = 0;
  EXPECT_TRUE(seen(without_bat).in_sight);
  auto without_ball = state_with(kBeside);
  without_ball.bodies[kBall].visible = 0;
  EXPECT_FALSE(seen(without_ball).in_sight);
}

TEST(BallInSight, RimOfTheBatIsWhereTheLineOfSightGrazesIt) {
  const auto scene = with(scene_for_tests(), "scene.bat_radius_m",
                          0.1);  // at 0.5 m; a ball at 1 m is hidden up to 0.2 m aside
  EXPECT_FALSE(seen(state_with({0.199, 0.0, 1.0}), scene).in_sight);
  EXPECT_TRUE(seen(state_with({0.201, 0.0, 1.0}), scene).in_sight);
}

TEST(GameRecord, SaysWhatAPictureShowsOfTheGame) {
  const auto at = [](Phase phase, int serves, int rally) {
    auto state = state_with(kBeside);
    state.counters[kPhase] = static_cast<std::int32_t>(phase);
    state.counters[kServes] = serves;
    state.counters[kRally] = rally;
    state.counters[kHits] = 7;
    return seen(state);
  };
  EXPECT_EQ(at(Phase::ready, 1, 0).going_on, "ball 2 waits to be served");
  EXPECT_EQ(at(Phase::incoming, 2, 0).going_on, "serve 2 on its way to the player");
  EXPECT_EQ(at(Phase::incoming, 2, 3).going_on, "the ball comes back from the wall");
  EXPECT_EQ(at(Phase::outgoing, 2, 3).going_on, "the ball on its way to the wall");
  EXPECT_EQ(at(Phase::outgoing, 2, 3).unseen,
            "the ball on its way to the wall, hidden by the bat or out of the picture");
  EXPECT_EQ(at(Phase::outgoing, 2, 3).just_after, "the bat has just met the ball");
  EXPECT_EQ(at(Phase::waiting, 2, 3).unseen, "between two balls");
  EXPECT_EQ(at(Phase::waiting, 2, 3).events, 7);
  EXPECT_EQ(at(Phase::waiting, 2, 3).event, "hit");
}

TEST(GameRecord, KeepsWhereTheBallWasInEachPictureThatHasOne) {
  GameRecord record({});
  auto state = state_with({0.25, -1.5, 1.125});
  state.time = Instant<PhysicsClock>{std::chrono::milliseconds(1500)};
  record.add_picture(state);
  state.bodies[kBall].visible = 0;
  record.add_picture(state);
  state = {};
  record.add_picture(state);
  EXPECT_EQ(record.tables(), (std::vector<std::string>{"time_s,x_m,y_m,z_m\n1.5,0.25,-1.5,1.125\n"}));
}

TEST(GameRecord, CountsAsTheLastStateDoes) {
  GameRecord record({});
  scene::SceneState state;
  for (int i = 1; i <= 3; ++i) {
    state.counters[kServes] = i;
    state.counters[kReturned] = i - 1;
    state.counters[kLongest] = 2 * i;
    state.counters[kHits] = 10 * i;
    record.add_state(state);
  }
  EXPECT_EQ(record.summary().dump(), R"({"rally":{"serves":3,"returned":2,"longest":6,"hits":30}})");
}

TEST(GameRecord, SaysAtTheEndWhatARallyCounts) {
  Json summary =
      Json::parse(R"({"rally": {"serves": 2, "returned": 1, "longest": 4}, "force": {"peak_n": 4.73}})");
  const auto lines = GameRecord({}).closing_lines(summary);
  ASSERT_EQ(lines.size(), 1u);
  EXPECT_EQ(lines[0].about, "rally");
  EXPECT_EQ(lines[0].text,
            "1 of 2 serves returned to the wall, longest rally 4 returns in a row, peak force 4.7 N");
  summary["match"] = {{"points", 12}, {"level", 2}};
  EXPECT_TRUE(
      GameRecord({}).closing_lines(summary)[0].text.ends_with("peak force 4.7 N; 12 points, level 2"));
  summary.erase("force");  // as of a person's own game
  EXPECT_TRUE(
      GameRecord({}).closing_lines(summary)[0].text.ends_with("4 returns in a row; 12 points, level 2"));
}

TEST(GameRecord, AnExampleShowsTheBallOnTheTableAndTheBatAtTheStylus) {
  scene::SceneDescription scene;
  scene.carried_offset = {0.0, 0.0, -0.1};
  scene.surfaces = {{"table", {Vector3(0, 1, 2), Vector3(1, 1, 2), Vector3(1, 1, 0), Vector3(0, 1, 0)}}};
  const auto state = example_state(scene, {Quaternion(0, 1, 0, 0), {3.0, 2.0, 1.0}});
  EXPECT_EQ(state.body_count, 2);
  EXPECT_LT((state.bodies[kBall].p() - Vector3(0.4, 1.024, 1.05)).norm(), 1e-12);
  EXPECT_LT((state.bodies[kBat].p() - Vector3(3.0, 2.0, 1.1)).norm(),
            1e-12);  // turned about x by 180 degrees
}

}  // namespace
}  // namespace palpate::applications::pingpong
