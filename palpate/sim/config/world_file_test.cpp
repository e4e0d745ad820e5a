#include "palpate/sim/config/world_file.h"

#include <gtest/gtest.h>

#include <numbers>

#include "palpate/core/file.h"
#include "palpate/rig/rig.h"

namespace palpate::sim::config {
namespace {

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
  const auto again = parse_world(text, "again");
  ASSERT_TRUE(again) << again.error().message;
  EXPECT_EQ(world_text(*again), text);
  EXPECT_EQ(again->tracker.white_rms, world.tracker.white_rms);
  EXPECT_EQ(again->arm.gain_sd, world.arm.gain_sd);
  EXPECT_EQ(again->scene.landmarks_moved_by, 0.008);
  EXPECT_EQ(again->display.extra_force_delay_s, 0.03);
}

TEST(WorldFile, WhatIsLeftOutIsTheReferences) {
  const auto world = parse_world("[arm]\nfriction_n = 0.5\n", "small.toml");
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

TEST(WorldFile, BallsFlyAsThePaperHasItWhereAsked) {
  EXPECT_EQ(reference_world().ball.physics, "full");
  EXPECT_EQ(reference_world().ball.contact, "non-sticky");
  const auto world = parse_world("[ball]\nphysics = \"paper\"\ncontact = \"hunt-crossley\"\n", "paper.toml");
  ASSERT_TRUE(world) << world.error().message;
  EXPECT_EQ(world->ball.physics, "paper");
  EXPECT_EQ(world->ball.contact, "hunt-crossley");
}

TEST(WorldFile, ABatIsHeldFastUnlessItsMassIsSaid) {
  EXPECT_EQ(reference_world().scene.bat_mass, 0.0);
  const auto world = parse_world("[scene]\nbat_mass_kg = 0.25\n", "bat.toml");
  ASSERT_TRUE(world) << world.error().message;
  EXPECT_EQ(world->scene.bat_mass, 0.25);
  EXPECT_NE(world_text(*world).find("bat_mass_kg = 0.25"), std::string::npos);
}

TEST(WorldFile, WhatIsTouchedIsWrittenAndReadAgain) {
  const auto world = parse_world(
      "[touch]\nmesh = \"liver.stl\"\nunit = \"m\"\nturn_deg = [90, 0, 0]\nstatic_friction = 0.5\n",
      "touch.toml");
  ASSERT_TRUE(world) << world.error().message;
  EXPECT_EQ(world->touch.mesh, "liver.stl");
  const auto again = parse_world(world_text(*world), "again.toml");
  ASSERT_TRUE(again) << again.error().message;
  EXPECT_EQ(again->touch.mesh, "liver.stl");
  EXPECT_EQ(again->touch.unit, "m");
  EXPECT_EQ(again->touch.turn, world->touch.turn);
  EXPECT_EQ(again->touch.static_friction, 0.5);
  EXPECT_EQ(again->touch.stiffness, 600.0);
  EXPECT_FALSE(parse_world("[touch]\nstatic_friction = 0.1\n", "low.toml")) << "less than it has sliding";
}

TEST(WorldFile, FaultsAreReadAndWrittenAndNoneIsThereUnlessSaid) {
  EXPECT_EQ(reference_world().faults.tracker_blind, (Range{0.0, 0.0}));
  const auto world = parse_world(
      "[faults]\ntracker_blind_s = [4, 5.5]\ncamera_clock_s = [7, 8]\nclock_jump_s = -2\nrepeat_s = 10\n",
      "faults.toml");
  ASSERT_TRUE(world) << world.error().message;
  const auto again = parse_world(world_text(*world), "again.toml");
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
                  "wires.toml");
  ASSERT_TRUE(world) << world.error().message;
  const auto again = parse_world(world_text(*world), "again.toml");
  ASSERT_TRUE(again) << again.error().message;
  EXPECT_EQ(again->arm_faults.mirrored_axis, 2);
  EXPECT_EQ(again->arm_faults.exchanged_joints, (std::array<int, 2>{1, 3}));
  EXPECT_EQ(again->arm_faults.torque_gains, (std::array<double, 3>{1.0, 0.0, 0.5}));
}

TEST(WorldFile, ARigFileInItsPlaceIsCalledThatAndTheWayToAWorldIsTold) {
  const auto world = parse_world(rig::rig_text(rig::Rig{}), "desk.toml");
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
  const auto world = parse_world(text, "two.toml");
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
      {"[ball]\nphysics = \"papyrus\"\n", "bad.toml:2", "paper"},
      {"[ball]\nrestitution_bat = 0.1\n", "bad.toml:2", "0.15 to 1"},
      {"[ball]\ncontact = \"glue\"\n", "bad.toml:2", "hunt-crossley"},
      {"[scene]\nbat_mass_kg = -0.1\n", "bad.toml:2", "0 to 10"},
      {"[scene]\nbat_mass_kg = 1000\n", "bad.toml:2", "0 to 10"},
      {"[scene]\nbat_mass_kg = 0.001\n", "bad.toml:2", "held fast"},
      {"[scene]\nbat_mass_kg = \"heavy\"\n", "bad.toml:2", "a number is expected"},
      {"[ball]\nmass_kg = 0.3\n[scene]\nbat_mass_kg = 0.17\n", "bad.toml:2", "lighter than the bat"},
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
    const auto world = parse_world(mistake.text, "bad.toml");
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
  for (const auto& world : {std::string(reference_world_text()), std::string("[ball]\nmass_kg = 0.003\n"),
                            std::string("[head]\nturn_hz = 1\n")}) {
    const auto words = complaint(world);
    EXPECT_EQ(words.find("rig.toml: is a world file"), 0u) << words;
    EXPECT_NE(words.find("a rig file is expected: `palpate demo` writes"), std::string::npos) << words;
  }
  EXPECT_EQ(complaint("[arm]\n").find("world file"), std::string::npos) << "both kinds have an arm";
}

}  // namespace
}  // namespace palpate::sim::config
