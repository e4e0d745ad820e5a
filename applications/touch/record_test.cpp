#include "applications/touch/record.h"

#include <gtest/gtest.h>

#include "applications/touch/touch.h"

namespace palpate::applications::touch {
namespace {

scene::SceneState at(int ms, double force, double sideways, bool sliding) {
  scene::SceneState state;
  state.time = Instant<PhysicsClock>{std::chrono::milliseconds(ms)};
  state.body_count = 3;
  state.bodies[kStylus].set_p({0.1, -1.4, 1.7});
  state.bodies[kStylus].set_v({0.005, 0.0, 0.0});
  state.continuous.point = {0.1, -1.5, 1.7};
  state.bodies[kProxy].set_p({0.1, -1.4, 1.7});  // the normal is up
  state.continuous.force = {sideways, force, 0.0};
  state.continuous.touching = force > 0.0 ? 1 : 0;
  state.counters[kDepthUm] = 2000;
  state.counters[kSliding] = sliding ? 1 : 0;
  state.counters[kTouches] = 2;
  state.counters[kSlips] = 1;
  state.counters[kUnsettled] = 3;
  return state;
}

TEST(TouchRecord, HasALineForEachMillisecondOfContact) {
  TouchRecord record;
  record.add_state(at(1000, 0.0, 0.0, false));
  record.add_state(at(1001, 3.0, 4.0, true));
  EXPECT_EQ(record.tables(),
            (std::vector<std::string>{
                "time_s,force_n,tangential_n,depth_mm,speed_mm_s,sliding,tip_x_m,tip_y_m,tip_z_m,normal_x,"
                "normal_y,normal_z\n1.001,5,4,2,5,1,0.1,-1.4,1.7,0,1,0\n"}));
}

TEST(TouchRecord, SumsUpTimeForceAndFriction) {
  TouchRecord record;
  for (int i = 0; i <= 10; ++i) record.add_state(at(i, i < 4 ? 0.0 : 2.0, i < 4 ? 0.0 : 0.6, i >= 8));
  const Json touch = record.summary()["touch"];
  EXPECT_NEAR(touch["of_s"].get<double>(), 0.010, 1e-12);
  EXPECT_NEAR(touch["contact_s"].get<double>(), 0.007, 1e-12);
  EXPECT_NEAR(touch["sliding_share"].get<double>(), 3.0 / 7.0, 1e-12);
  EXPECT_NEAR(touch["force_n"]["mean"].get<double>(), std::hypot(2.0, 0.6), 1e-12);
  EXPECT_NEAR(touch["depth_mm"]["max"].get<double>(), 2.0, 1e-12);
  EXPECT_NEAR(touch["friction"]["median"].get<double>(), 0.3, 1e-9);
  EXPECT_EQ(touch["touches"], 2);
  EXPECT_EQ(touch["slips"], 1);
  EXPECT_EQ(touch["unsettled"], 3);
}

TEST(TouchRecord, OfAPlayWithoutContactThereAreNoSpreads) {
  TouchRecord record;
  record.add_state(at(0, 0.0, 0.0, false));
  const Json touch = record.summary()["touch"];
  EXPECT_EQ(touch["contact_s"], 0.0);
  EXPECT_TRUE(touch["force_n"].empty());
  EXPECT_FALSE(touch.contains("friction"));
}

TEST(TouchRecord, SaysWhatTheTipDoesAndWhetherItIsInThePicture) {
  const device::CameraModel lens{.width = 64, .height = 48, .fx = 56.0, .fy = 56.0, .cx = 32.0, .cy = 24.0};
  const auto seen = [&lens](const scene::SceneState& state) {
    return TouchRecord().highlight({.state = state, .have_state = true, .lens = lens, .X_world_camera = {}});
  };
  auto state = at(0, 1.0, 0.0, false);
  state.bodies[kProxy].set_p({0.0, 0.0, 0.5});
  EXPECT_TRUE(seen(state).in_sight);
  EXPECT_EQ(seen(state).going_on, "the tip above the surface");
  state.counters[kForceMn] = 900;
  EXPECT_EQ(seen(state).going_on, "the tip holds on the surface");
  state.counters[kSliding] = 1;
  EXPECT_EQ(seen(state).going_on, "the tip slides over the surface");
  EXPECT_EQ(seen(state).unseen, "the tip slides over the surface, out of the picture");
  EXPECT_EQ(seen(state).just_after, "the tip has just met the surface");
  EXPECT_EQ(seen(state).events, 2);
  state.bodies[kProxy].set_p({0.0, 0.0, -0.5});
  EXPECT_FALSE(seen(state).in_sight);
  state.body_count = 2;
  EXPECT_FALSE(seen(state).in_sight);
}

TEST(TouchRecord, SaysAtTheEndHowTheSurfaceWasTouched) {
  const Json summary = Json::parse(
      R"({"touch": {"touches": 3, "contact_s": 8.44, "of_s": 12, "slips": 177, "force_n": {"max": 5.9}},
          "force": {"peak_n": 8.1}})");
  const auto lines = TouchRecord().closing_lines(summary);
  ASSERT_EQ(lines.size(), 1u);
  EXPECT_EQ(lines[0].about, "touch");
  EXPECT_EQ(lines[0].text, "touched 3 times, 8.4 of 12.0 s on the surface, 177 slips, peak force 5.9 N");
  const Json untouched =
      Json::parse(R"({"touch": {"touches": 0, "contact_s": 0, "of_s": 29.4, "slips": 0, "force_n": {}}})");
  EXPECT_EQ(TouchRecord().closing_lines(untouched)[0].text,
            "touched 0 times, 0.0 of 29.4 s on the surface, 0 slips, peak force 0.0 N");
}

}  // namespace
}  // namespace palpate::applications::touch
