#include "palpate/sim/config/world_file.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <numbers>

#include "palpate/core/file.h"
#include "palpate/rig/rig.h"
#include "tests/scratch_folder.h"

namespace palpate::sim::config {
namespace {

// An application that lets people set a field of every kind.
scene::ApplicationRegistry darts() {
  using scene::SettingKind;
  scene::ApplicationSpec spec;
  spec.name = "darts";
  spec.summary = "Throw";
  spec.settings.fields = {{.section = "darts",
                           .key = "mass_g",
                           .initial = std::vector<double>{20.0},
                           .unit = 1e-3,
                           .range = {0.0, 100.0}},
                          {.section = "darts",
                           .key = "board",
                           .kind = SettingKind::choice,
                           .initial = "round",
                           .choices = {"round", "square"}},
                          {.section = "darts", .key = "picture", .kind = SettingKind::file, .initial = ""},
                          {.section = "scene",
                           .key = "dart_offset_m",
                           .kind = SettingKind::numbers,
                           .initial = std::vector<double>{0.0, 0.0, 0.125}}};
  spec.settings.relations = [](const scene::SettingValues& values) -> std::vector<scene::SettingComplaint> {
    if (values.number("darts.mass_g") < 0.050) return {};
    return {{"darts", "mass_g", "a dart lighter than 50 g is expected"}};
  };
  spec.make_physics = [](const auto&, const auto&) { return nullptr; };
  spec.make_view = [](const auto&) { return nullptr; };
  return {spec};
}

TEST(WorldFile, ReferenceWorldIsTheFileInTheDataFolder) {
  const auto content = read_file(PALPATE_DATA_DIR "/worlds/reference.toml");
  ASSERT_TRUE(content);
  EXPECT_EQ(*content, reference_world_text());
  const auto& world = reference_world();
  EXPECT_DOUBLE_EQ(world.tracker.white_rms, 0.165e-3);
  EXPECT_DOUBLE_EQ(world.arm.joint_range[1][1], 85.0 / 180.0 * std::numbers::pi);
  EXPECT_EQ(world.scene.wall[3], Vector3(-0.375, -0.92, 0.80));
  EXPECT_EQ(world.tip_marker.leds.size(), 6u);
}

TEST(WorldFile, WrittenTextReadsBackToTheSameText) {
  auto world = reference_world();
  world.arm.gain_sd = 0.1234567890123;
  world.tracker.white_rms = 1e-3 / 3.0;
  world.camera.shutter = "rolling";
  world.camera.readout_s = 0.02;
  world.camera.blur_steps = 3;
  world.scene.landmarks_covered = 0.5;
  world.scene.landmarks_moved = 2;
  world.scene.landmarks_moved_by = 0.008;
  world.display = {"predicted", 0.008, 0.02, 0.03};
  const auto text = world_text(world);
  const auto again = parse_world(text, "again", {});
  ASSERT_TRUE(again) << again.error().message;
  EXPECT_EQ(world_text(*again), text);
  EXPECT_EQ(again->tracker.white_rms, world.tracker.white_rms);
  EXPECT_EQ(again->arm.gain_sd, world.arm.gain_sd);
  EXPECT_EQ(again->scene.landmarks_moved_by, 0.008);
  EXPECT_EQ(again->display.extra_force_delay_s, 0.03);
}

TEST(WorldFile, WhatIsLeftOutIsTheReferences) {
  const auto world = parse_world("[arm]\nfriction_n = 0.5\n", "small.toml", {});
  ASSERT_TRUE(world) << world.error().message;
  EXPECT_EQ(world->arm.friction, 0.5);
  auto expected = reference_world();
  expected.arm.friction = 0.5;
  EXPECT_EQ(world_text(*world), world_text(expected));
}

struct Mistake {
  const char* text;
  const char* line;  // of the file, as it must be named
  const char* word;
};

TEST(WorldFile, WhatAnApplicationLetsPeopleSetStandsInTheSameFile) {
  const auto text = world_text(reference_world(darts()));
  // Keys in a section of the laboratory at its end, sections of its own after [display].
  EXPECT_NE(text.find("landmarks_moved_by_mm = 0.0\ndart_offset_m = [0.0, 0.0, 0.125]\n\n[display]"),
            std::string::npos)
      << text;
  EXPECT_NE(text.find("\n\n[darts]\nmass_g = 20.0\nboard = \"round\"\npicture = \"\"\n\n[faults]"),
            std::string::npos)
      << text;
  const auto world =
      parse_world("[darts]\nmass_g = 22.5\nboard = \"square\"\n[scene]\ndart_offset_m = [1, 2, 3]\n",
                  "darts.toml", darts());
  ASSERT_TRUE(world) << world.error().message;
  EXPECT_DOUBLE_EQ(world->settings.number("darts.mass_g"), 0.0225);
  EXPECT_EQ(world->settings.text("darts.board"), "square");
  EXPECT_EQ(world->settings.vector("scene.dart_offset_m"), Vector3(1.0, 2.0, 3.0));
  const auto again = parse_world(world_text(*world), "again.toml", darts());
  ASSERT_TRUE(again) << again.error().message;
  EXPECT_EQ(world_text(*again), world_text(*world));
}

TEST(WorldFile, AFileIsNamedAsSeenFromTheWorldFile) {
  const ScratchFolder folder;
  const auto picture_in = [&](const std::string& said) {
    EXPECT_TRUE(write_file(folder / "w.toml", "[darts]\npicture = \"" + said + "\"\n"));
    const auto world = read_world(folder / "w.toml", darts());
    return world ? world->settings.text("darts.picture") : world.error().message;
  };
  EXPECT_EQ(picture_in("../board.png"), (folder.path().parent_path() / "board.png").string());
  EXPECT_EQ(picture_in("/else/board.png"), "/else/board.png");
  EXPECT_EQ(picture_in(""), "");
}

TEST(WorldFile, WhatTheReferenceNamesIsNoMistakeWhereNoApplicationHasIt) {
  EXPECT_TRUE(parse_world(reference_world_text(), "reference.toml", {}));
  EXPECT_EQ(world_text(reference_world()).find("mass_g"), std::string::npos);
  // Of an application that is not here, and not in the reference.
  EXPECT_FALSE(parse_world("[darts]\nmass_g = 20\n", "darts.toml", {}));
}

TEST(WorldFile, AnApplicationThatClaimsAKeyOfTheLaboratoryIsNamed) {
  auto spec = darts().specs().front();
  spec.settings.fields[0].section = "camera";
  spec.settings.fields[0].key = "fx";
  spec.settings.relations = nullptr;
  const auto world = parse_world("", "w.toml", {spec});
  ASSERT_FALSE(world);
  EXPECT_NE(world.error().message.find("camera.fx: is the laboratory's"), std::string::npos)
      << world.error().message;
}

TEST(WorldFile, FaultsAreReadAndWrittenAndNoneIsThereUnlessSaid) {
  EXPECT_EQ(reference_world().faults.tracker_blind, (Range{0.0, 0.0}));
  const auto world = parse_world(
      "[faults]\ntracker_blind_s = [4, 5.5]\ncamera_clock_s = [7, 8]\nclock_jump_s = -2\nrepeat_s = 10\n",
      "faults.toml", {});
  ASSERT_TRUE(world) << world.error().message;
  const auto again = parse_world(world_text(*world), "again.toml", {});
  ASSERT_TRUE(again) << again.error().message;
  EXPECT_EQ(again->faults.tracker_blind, (Range{4.0, 5.5}));
  EXPECT_EQ(again->faults.camera_clock, (Range{7.0, 8.0}));
  EXPECT_EQ(again->faults.camera_silent, (Range{0.0, 0.0}));
  EXPECT_EQ(again->faults.clock_jump_s, -2.0);
  EXPECT_EQ(again->faults.repeat_s, 10.0);
}

TEST(WorldFile, AnArmWiredWronglyIsReadAndWrittenAndNoneIsThereUnlessSaid) {
  EXPECT_EQ(reference_world().arm_faults.mirrored_axis, 0);
  EXPECT_EQ(reference_world_text().find("arm_faults"), std::string_view::npos);
  const auto world =
      parse_world("[arm_faults]\nmirrored_axis = 2\nexchanged_joints = [1, 3]\ntorque_gains = [1, 0, 0.5]\n",
                  "wires.toml", {});
  ASSERT_TRUE(world) << world.error().message;
  const auto again = parse_world(world_text(*world), "again.toml", {});
  ASSERT_TRUE(again) << again.error().message;
  EXPECT_EQ(again->arm_faults.mirrored_axis, 2);
  EXPECT_EQ(again->arm_faults.exchanged_joints, (std::array<int, 2>{1, 3}));
  EXPECT_EQ(again->arm_faults.torque_gains, (std::array<double, 3>{1.0, 0.0, 0.5}));
}

TEST(WorldFile, WhatWasKnockedSinceIsReadAndWrittenAndNothingIsUnlessSaid) {
  EXPECT_FALSE(reference_world().knock.any());
  EXPECT_EQ(world_text(reference_world()).find("[knock]"), std::string::npos);
  const auto world = parse_world(
      "[knock]\ncamera_mm = [1, 0, -2]\nbase_deg = [0, 90, 0]\npointer_tip_mm = [0, 0.5, 0]\nfocus_percent = "
      "-1.5\nprincipal_point_px = [2, -3]\n",
      "knocked.toml", {});
  ASSERT_TRUE(world) << world.error().message;
  const auto again = parse_world(world_text(*world), "again.toml", {});
  ASSERT_TRUE(again) << again.error().message;
  EXPECT_TRUE(again->knock.any());
  EXPECT_EQ(again->knock.camera, Vector3(0.001, 0.0, -0.002));
  EXPECT_NEAR(again->knock.base_turn.y(), 1.5707963, 1e-6);
  EXPECT_EQ(again->knock.pointer_tip, Vector3(0.0, 0.0005, 0.0));
  EXPECT_NEAR(again->knock.focus, -0.015, 1e-15);
  EXPECT_EQ(again->knock.principal_point, (std::array<double, 2>{2.0, -3.0}));
}

TEST(WorldFile, ARigFileInItsPlaceIsCalledThatAndTheWayToAWorldIsTold) {
  const auto world = parse_world(rig::rig_text(rig::Rig{}), "desk.toml", {});
  ASSERT_FALSE(world);
  EXPECT_EQ(world.error().kind, Error::Kind::wrong_use);
  EXPECT_EQ(world.error().message.find("desk.toml: is a rig file"), 0u) << world.error().message;
  EXPECT_NE(world.error().message.find("`palpate world new FILE` writes one"), std::string::npos);
}

// Who has the file before him finds the switch in it.
TEST(WorldFile, TheReferenceSaysThatThereCanBeTwoEyes) {
  std::string text(reference_world_text());
  const auto at = text.find("\ncount = 1 ");
  ASSERT_NE(at, std::string::npos);
  EXPECT_NE(text.substr(at, text.find('\n', at + 1) - at).find("two eyes"), std::string::npos);
  text.replace(at, 10, "\ncount = 2");
  const auto world = parse_world(text, "two.toml", {});
  ASSERT_TRUE(world) << world.error().message;
  EXPECT_EQ(world->camera.count, 2);
}

TEST(WorldFile, MistakesAreNamedWithFileLineAndKey) {
  const Mistake mistakes[] = {
      {"[arm]\ngain_sdd = 0.1\n", "bad.toml:2", "gain_sdd"},
      {"[arm]\n\nfriction_n = \"much\"\n", "bad.toml:3", "friction_n"},
      {"[tracker]\nled_white_rms_mm = -1\n", "bad.toml:2", "led_white_rms_mm"},
      {"[tracker]\ndropout_probability = 1.5\n", "bad.toml:2", "dropout_probability"},
      {"[armm]\nfriction_n = 1\n", "bad.toml:1", "armm"},
      {"[pointer]\nleds_mm = [[0, 0, 0], [1, 0, 0]]\n", "bad.toml:2", "leds_mm"},
      {"[pointer]\nleds_mm = [[0, 0, 0], [50, 0, 0], [90, 0, 0]]\n", "bad.toml:2", "line"},
      {"[tracker]\ncamera_positions_m = [[0, 0, 0], [1, 0, 0]]\n", "bad.toml:2", "camera_positions_m"},
      {"[arm]\njoint_range_deg = [[45, -45], [-10, 85], [-25, 65]]\n", "bad.toml:2", "joint_range_deg"},
      {"[camera]\nshutter = \"global\"\nexposure_ms = 50\n", "bad.toml:3", "exposure_ms"},
      {"[camera]\nshutter = \"rolling\"\n", "bad.toml:2", "readout_ms"},
      {"[camera]\nblur_steps = 4\n", "bad.toml:2", "must be odd"},
      {"[scene]\nlandmarks_covered = 1.5\n", "bad.toml:2", "landmarks_covered"},
      {"[scene]\nlandmarks_moved = 13\n", "bad.toml:2", "more than there are"},
      {"[display]\npicture_time = \"tomorrow\"\n", "bad.toml:2", "predicted"},
      {"[display]\nextra_picture_delay_ms = -1\n", "bad.toml:2", "extra_picture_delay_ms"},
      {"[display]\nextra_force_delay_ms = 500\n", "bad.toml:2", "extra_force_delay_ms"},
      {"[clocks]\narm = { offset = 1 }\n", "bad.toml:2", "offset"},
      {"[darts]\nmass_g = -0.1\n", "bad.toml:2", "0 to 100"},
      {"[darts]\n\nmass_g = \"heavy\"\n", "bad.toml:3", "a number is expected"},
      {"[darts]\nboard = \"oval\"\n", "bad.toml:2", "square"},
      {"[darts]\nmas_g = 20\n", "bad.toml:2", "mas_g"},
      {"[darts]\npicture = 3\n", "bad.toml:2", "picture"},
      {"[scene]\ndart_offset_m = [1, 2]\n", "bad.toml:2", "dart_offset_m"},
      {"[darts]\nmass_g = 60\n", "bad.toml:2", "lighter than 50 g"},
      {"[arm_faults]\nexchanged_joints = [2, 2]\n", "bad.toml:2", "two different joints"},
      {"[arm_faults]\nexchanged_joints = [0, 2]\n", "bad.toml:2", "two different joints"},
      {"[arm_faults]\nmirrored_axis = 4\n", "bad.toml:2", "mirrored_axis"},
      {"[faults]\ncamera_dark_s = [1, 2]\n", "bad.toml:2", "camera_dark_s"},
      {"[faults]\ncamera_silent_s = [3, 2]\n", "bad.toml:2", "from <= until"},
      {"[faults]\ncamera_silent_s = [-1, 2]\n", "bad.toml:2", "camera_silent_s"},
      {"[faults]\ntracker_blind_s = [3, 8]\nrepeat_s = 5\n", "bad.toml:2", "repeat_s = 5"},
      {"[world]\nrate_hz = 4000\nrate_hz = 5000\n", "bad.toml", "rate_hz"},
  };
  for (const auto& mistake : mistakes) {
    const auto world = parse_world(mistake.text, "bad.toml", darts());
    ASSERT_FALSE(world) << mistake.text;
    EXPECT_EQ(world.error().kind, Error::Kind::wrong_use);
    EXPECT_NE(world.error().message.find(mistake.line), std::string::npos) << world.error().message;
    EXPECT_NE(world.error().message.find(mistake.word), std::string::npos) << world.error().message;
    EXPECT_EQ(world.error().message.find('\n'), std::string::npos);
  }
}

TEST(WorldFile, AWorldFileInItsPlaceIsCalledThatAndTheWayToARigIsTold) {
  const auto complaint = [](const std::string& text) {
    const auto rig = rig::parse_rig(text, "rig.toml");
    return rig ? std::string() : rig.error().message;
  };
  for (const auto& world : {std::string(reference_world_text()), std::string("[faults]\nrepeat_s = 3\n"),
                            std::string("[head]\nturn_hz = 1\n")}) {
    const auto words = complaint(world);
    EXPECT_EQ(words.find("rig.toml: is a world file"), 0u) << words;
    EXPECT_NE(words.find("a rig file is expected: `palpate demo` writes"), std::string::npos) << words;
  }
  EXPECT_EQ(complaint("[arm]\n").find("world file"), std::string::npos) << "both kinds have an arm";
}

}  // namespace
}  // namespace palpate::sim::config
