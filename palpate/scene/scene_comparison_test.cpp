#include "palpate/scene/scene_comparison.h"

#include <gtest/gtest.h>

#include <limits>

namespace palpate::scene {
namespace {

SceneSurface rectangle(const char* name, double x = 0.0) {
  return {name, {Vector3(x, 0, 0), Vector3(x + 1, 0, 0), Vector3(x + 1, 0, -1), Vector3(x, 0, -1)}};
}

SceneDescription game() {
  SceneDescription scene;
  scene.application = "game";
  scene.surfaces = {rectangle("table")};
  scene.bodies = {{"Ball", 0.003}, {"Bat", 0.0}};
  scene.mesh = MeshAsset{"/there/bat.stl", "a1b2", 0.001, nullptr};
  scene.settings = {1, "slow"};
  scene.shape_vertices = 7;
  return scene;
}

TEST(SceneComparison, TheSameSceneFitsWhereverItsFileLies) {
  SceneDescription played = game();
  played.mesh->file = "/here/bat.stl";
  played.mesh->mesh = std::make_shared<TriangleMesh>();
  played.bodies[0].mass = 0.004;
  played.surfaces = {};
  EXPECT_EQ(other_than_drawn(game(), played), std::nullopt);
}

TEST(SceneComparison, AnotherApplicationIsSaidByItsNameAlone) {
  SceneDescription played;
  played.application = "touch\n";
  const auto words = other_than_drawn(game(), played);
  ASSERT_TRUE(words);
  EXPECT_EQ(words->find("touch"), 0u) << *words;
  EXPECT_NE(words->find(", not game"), std::string::npos) << *words;
  EXPECT_EQ(words->find('\n'), std::string::npos) << "a name from another machine";
  EXPECT_EQ(words->find("with"), std::string::npos) << *words;
}

TEST(SceneComparison, WhatElsePicturesAreMadeOfIsSaid) {
  struct Case {
    void (*change)(SceneDescription&);
    const char* words;
  };
  const Case cases[] = {
      {[](SceneDescription& s) { s.bodies.pop_back(); }, "game with 1 body, not 2"},
      {[](SceneDescription& s) { s.bodies[1].name = "Cup"; }, "game with body 1 'Cup', not 'Bat'"},
      {[](SceneDescription& s) { s.mesh.reset(); }, "game with no mesh"},
      {[](SceneDescription& s) { s.mesh->hash = "a1b3"; }, "game with another mesh"},
      {[](SceneDescription& s) { s.mesh->metres_per_unit = 1.0; }, "game with another mesh"},
      {[](SceneDescription& s) { s.shape_vertices = 8; }, "game with a soft surface of 8 vertices, not 7"},
      {[](SceneDescription& s) { s.settings.bytes = "fast"; }, "game with other settings"},
      {[](SceneDescription& s) { s.carried_offset.z() = 0.01; }, "game with the stylus held elsewhere"},
      {[](SceneDescription& s) { s.gravity.y() = -1.6; }, "game with another gravity"},
      {[](SceneDescription& s) { s.settings.version = 2, s.bodies.pop_back(); },
       "game with 1 body, not 2, other settings"},
  };
  for (const auto& one : cases) {
    SceneDescription played = game();
    one.change(played);
    EXPECT_EQ(other_than_drawn(game(), played), one.words);
  }
  SceneDescription bare = game();
  bare.mesh.reset();
  EXPECT_EQ(other_than_drawn(bare, game()), "game with a mesh");
}

SceneDescription with(std::vector<SceneSurface> surfaces) {
  SceneDescription scene;
  scene.surfaces = std::move(surfaces);
  return scene;
}

TEST(RigComparison, TwoMillimetresAreTheSamePlaceAndTwoCentimetresAreNot) {
  const SceneDescription here = with({rectangle("table"), rectangle("wall")});
  const auto moved = [&](double by) {
    auto there = here;
    there.surfaces[1].corners[2].y() += by;
    std::swap(there.surfaces[0], there.surfaces[1]);  // in whatever order
    return compare_rigs(here, there);
  };
  EXPECT_TRUE(moved(0.0019).agree());
  EXPECT_EQ(moved(0.0019).words(), "");
  const auto warned = moved(0.0123);
  EXPECT_FALSE(warned.agree());
  EXPECT_FALSE(warned.elsewhere());
  EXPECT_EQ(warned.words(), "'wall' lies 12 mm from where it lies here");
  EXPECT_FALSE(moved(0.0199).elsewhere());
  EXPECT_TRUE(moved(0.0201).elsewhere());
  EXPECT_TRUE(moved(std::numeric_limits<double>::quiet_NaN()).elsewhere());
}

TEST(RigComparison, TheFarthestIsNamedAndTheMissingOnBothSides) {
  const SceneDescription here = with({rectangle("table"), rectangle("wall"), rectangle("door")}),
                         there = with({rectangle("wall", 0.3), rectangle("table", 0.1), rectangle("sill")});
  const auto compared = compare_rigs(here, there);
  EXPECT_EQ(compared.words(),
            "'wall' lies 300 mm from where it lies here, 'door' is missing there, 'sill' is missing here");
  EXPECT_FALSE(compare_rigs(here, {}).agree());
  EXPECT_FALSE(compare_rigs(here, {}).elsewhere()) << "nothing lies in another place";
  EXPECT_FALSE(compare_rigs({}, there).agree());
  const SceneDescription many = with(std::vector<SceneSurface>(6, rectangle("x")));
  EXPECT_EQ(compare_rigs(many, {}).words(), "'x', 'x', 'x', 'x', 2 more are missing there");
}

TEST(RigComparison, AnArmThatPutsTheTipElsewhereIsSaid) {
  SceneDescription here;
  here.arm_tips = {{0.0, 0.1, 0.2}, {0.0, 0.2, 0.2}, {0.1, 0.1, 0.2}, {0.0, 0.1, 0.3}};
  SceneDescription there = here;
  EXPECT_TRUE(compare_rigs(here, there).agree());
  there.arm_tips[2].z() += 0.0019;
  EXPECT_TRUE(compare_rigs(here, there).agree());
  there.arm_tips[2].z() += 0.005;
  EXPECT_FALSE(compare_rigs(here, there).agree());
  EXPECT_FALSE(compare_rigs(here, there).elsewhere());
  EXPECT_EQ(compare_rigs(here, there).words(),
            "equal readings of the arm put the tip 7 mm from where they do here");
  there.arm_tips[2].z() += 0.02;
  EXPECT_TRUE(compare_rigs(here, there).elsewhere());
  there.arm_tips.pop_back();
  EXPECT_TRUE(compare_rigs(here, there).elsewhere());
  EXPECT_EQ(compare_rigs(here, there).words(), "its arm has another number of joints");
  there.arm_tips.clear();
  EXPECT_TRUE(compare_rigs(here, there).agree()) << "a server of before does not say";
}

}  // namespace
}  // namespace palpate::scene
