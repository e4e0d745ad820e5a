#include "applications/touch/settings.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <numbers>
#include <stdexcept>

namespace palpate::applications::touch {
namespace {

scene::SettingValues initial() { return scene::SettingValues(setting_schema()); }

TEST(TouchSettings, InitiallyTheOrganIsTouchedWithABareStylus) {
  scene::SceneDescription scene;
  scene.carried_offset = {1.0, 2.0, 3.0};
  describe(initial(), scene);
  EXPECT_EQ(scene.carried_offset, Vector3(0.0, 0.0, 0.0));
  EXPECT_FALSE(scene.mesh);
  const SurfaceSettings surface = surface_settings(scene), plain;
  EXPECT_EQ(surface.mesh_file, "");
  EXPECT_EQ(surface.shift, Vector3(0.08, 0.06, 0.04));
  EXPECT_EQ(surface.stiffness, plain.stiffness);
  EXPECT_EQ(surface.friction, plain.friction);
}

TEST(TouchSettings, WhatIsSetArrivesThroughTheScene) {
  auto values = initial();
  values.set("touch.mesh", "/meshes/liver.stl");
  values.set("touch.unit", "m");
  values.set("touch.scale", 2.5);
  values.set("touch.turn_deg", std::vector<double>{90.0, 0.0, -30.0});
  values.set("touch.stiffness_n_m", 110.0);
  values.set("touch.static_friction", 0.2);
  values.set("touch.friction", 0.15);
  scene::SceneDescription scene;
  describe(values, scene);
  ASSERT_TRUE(scene.mesh);
  EXPECT_EQ(scene.mesh->file, "/meshes/liver.stl");
  EXPECT_EQ(scene.mesh->metres_per_unit, 2.5);
  const SurfaceSettings surface = surface_settings(scene);
  EXPECT_DOUBLE_EQ(surface.turn.x(), 0.5 * std::numbers::pi);
  EXPECT_DOUBLE_EQ(surface.turn.z(), -std::numbers::pi / 6.0);
  EXPECT_EQ(surface.stiffness, 110.0);
  EXPECT_EQ(surface.static_friction, 0.2);
  EXPECT_EQ(surface.friction, 0.15);
}

TEST(TouchSettings, MaterialsThatNoArmRendersAreRefused) {
  for (const auto& [name, value] : {std::pair{"touch.stiffness_n_m", 3000.0},
                                    {"touch.stiffness_n_m", 0.0},
                                    {"touch.damping_n_s_m", -1.0},
                                    {"touch.friction", 0.5}}) {
    auto values = initial();
    values.set(name, value);
    EXPECT_FALSE(check(setting_schema(), values)) << name << ' ' << value;
    scene::SceneDescription scene;
    describe(values, scene);
    EXPECT_THROW(surface_settings(scene), std::invalid_argument) << name << ' ' << value;
  }
}

TEST(TouchSettings, OptionsOfTheCommandLineGoOverTheValues) {
  auto values = initial();
  const auto say = [&values](const std::string& name, const std::string& said) {
    for (const auto& option : options())
      if (option.name == name) return option.apply(said, values);
    return Expected<void>(wrong_use("no option {}", name));
  };
  const auto unit_alone = say("--unit", "m");
  ASSERT_FALSE(unit_alone);
  EXPECT_EQ(unit_alone.error().message, "--unit m: no mesh is named; say which with --mesh FILE");
  EXPECT_EQ(say("--turn-deg", "-90,0,0").error().message,
            "--turn-deg -90,0,0: no mesh is named; say which with --mesh FILE");
  ASSERT_TRUE(say("--mesh", "liver.stl"));
  EXPECT_EQ(values.text("touch.mesh"), (std::filesystem::current_path() / "liver.stl").string());
  ASSERT_TRUE(say("--unit", "m"));
  EXPECT_EQ(values.text("touch.unit"), "m");
  ASSERT_TRUE(say("--turn-deg", "-90,0,12.5"));
  EXPECT_EQ(values.at("touch.turn_deg").value, scene::SettingValue(std::vector<double>{-90.0, 0.0, 12.5}));
  for (const std::string wrong : {"", "1,2", "1,2,3,4", "1,2,x", "1,,3", "1,2,3 ", "nan,0,0", "0,0,361"})
    EXPECT_FALSE(say("--turn-deg", wrong)) << wrong;
  ASSERT_TRUE(say("--colour", "bone"));
  scene::SceneDescription scene;
  describe(values, scene);
  EXPECT_EQ(surface_settings(scene).colour, "bone");
  for (const std::string material : {"plain", "bone", "soft-tissue"}) {
    ASSERT_TRUE(say("--material", material));
    EXPECT_TRUE(check(setting_schema(), values)) << material;
  }
  EXPECT_EQ(values.number("touch.stiffness_n_m"), 110.0) << "docs/guides/touch.md";
  EXPECT_EQ(values.number("touch.friction"), 0.15);
}

}  // namespace
}  // namespace palpate::applications::touch
