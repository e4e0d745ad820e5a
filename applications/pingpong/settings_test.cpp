#include "applications/pingpong/settings.h"

#include <gtest/gtest.h>

#include <cmath>
#include <stdexcept>

namespace palpate::applications::pingpong {
namespace {

scene::SettingValues initial() { return scene::SettingValues(setting_schema()); }

// The numbers are those of the paper's ball and a bat that is held fast.
TEST(PingPongSettings, InitiallyAreTheReferenceGame) {
  const GameSettings game = game_settings(initial());
  EXPECT_EQ(game, GameSettings{});
  EXPECT_EQ(game.ball_mass, 0.0027);
  EXPECT_EQ(game.contact_s, 0.004);
  EXPECT_TRUE(std::isinf(game.bat_mass));
}

TEST(PingPongSettings, WhatIsSetArrivesThroughTheScene) {
  auto values = initial();
  values.set("ball.mass_kg", 0.003);
  values.set("ball.radius_m", 0.021);
  values.set("ball.restitution_table", 0.9);
  values.set("ball.restitution_bat", 0.7);
  values.set("ball.contact_ms", 3.7);
  values.set("ball.serve_speed_m_s", std::vector<double>{1.0, 1.5});
  values.set("match.serves", 12.0);
  values.set("match.level", 3.0);
  values.set("ball.physics", "paper");
  values.set("ball.contact", "hunt-crossley");
  values.set("scene.bat_radius_m", 0.08);
  values.set("scene.bat_mass_kg", 0.25);
  values.set("scene.bat_offset_m", std::vector<double>{0.01, 0.02, -0.1});
  scene::SceneDescription scene;
  describe(values, scene);
  EXPECT_EQ(scene.carried_offset, Vector3(0.01, 0.02, -0.1));
  ASSERT_EQ(scene.bodies.size(), 2u);
  EXPECT_EQ(scene.bodies[0].name, "Ball");
  EXPECT_EQ(scene.bodies[0].mass, 0.003);
  EXPECT_EQ(scene.bodies[scene::kCarried].name, "Bat");
  const GameSettings expected{.ball_radius = 0.021,
                              .ball_mass = 0.003,
                              .surface_restitution = 0.9,
                              .bat_radius = 0.08,
                              .bat_restitution = 0.7,
                              .bat_mass = 0.25,
                              .contact_s = 3.7 * 1e-3,
                              .flight = Flight::paper,
                              .contact_model = scene::ContactModel::hunt_crossley,
                              .serve_speed = {1.0, 1.5},
                              .match = {12, 3}};
  EXPECT_EQ(game_settings(scene), expected);
}

TEST(PingPongSettings, ASceneWithAnothersPayloadIsRefusedInWords) {
  scene::SceneDescription scene;
  EXPECT_EQ(game_settings(scene), GameSettings{}) << "no payload: the initial values";
  scene.settings = {1, "{\"ball\": {\"mass_kg\": 0.0027}}"};
  try {
    static_cast<void>(game_settings(scene));
    FAIL() << "a payload that lacks most of it was taken";
  } catch (const std::invalid_argument& thrown) {
    EXPECT_EQ(std::string(thrown.what()).find("pingpong: scene.bat_radius_m: is not among"), 0u)
        << thrown.what();
  }
}

TEST(PingPongSettings, ABatIsHeavierThanTheBall) {
  auto values = initial();
  values.set("ball.mass_kg", 0.3);
  EXPECT_TRUE(check(setting_schema(), values)) << "held fast";
  values.set("scene.bat_mass_kg", 0.17);
  const auto lighter = check(setting_schema(), values);
  ASSERT_FALSE(lighter);
  EXPECT_EQ(lighter.error().message,
            "ball.mass_kg: is 0.3, the bat's 0.17; a ball lighter than the bat is expected");
  values.set("scene.bat_mass_kg", 0.001);
  EXPECT_NE(check(setting_schema(), values).error().message.find("0 (held fast)"), std::string::npos);
}

TEST(PingPongSettings, AMatchHasWholeNumbers) {
  auto values = initial();
  values.set("match.level", 2.5);
  EXPECT_EQ(check(setting_schema(), values).error().message,
            "match.level: is 2.5, a whole number is expected");
  values.set("match.level", 6.0);
  EXPECT_FALSE(check(setting_schema(), values));
}

TEST(PingPongSettings, APersonBeginsWithSlowServes) {
  auto values = initial();
  ease_for_a_person(values);
  EXPECT_EQ(values.range("ball.serve_speed_m_s"), (std::array{2.0, 2.3}));
  EXPECT_EQ(game_settings(values).match, (MatchSettings{20, 1}));
  values.set("match.serves", 0.0);
  values.set("ball.serve_speed_m_s", std::vector<double>{2.6, 3.0});  // asked for faster ones
  ease_for_a_person(values);
  EXPECT_EQ(values.range("ball.serve_speed_m_s"), (std::array{2.6, 2.6}));
  EXPECT_EQ(game_settings(values).match.serves, 0) << "a match would have serves of its own";
}

TEST(PingPongSettings, ASceneOfAnotherReleaseIsRefusedInWords) {
  scene::SceneDescription scene;
  describe(initial(), scene);
  scene.settings.version = 2;
  try {
    static_cast<void>(game_settings(scene));
    FAIL() << "a payload of another version was taken";
  } catch (const std::invalid_argument& thrown) {
    EXPECT_STREQ(thrown.what(),
                 "pingpong: its settings are of version 2, this side knows 1; use the same release on both");
  }
}

}  // namespace
}  // namespace palpate::applications::pingpong
