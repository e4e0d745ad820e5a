#include "palpate/sim/simulator.h"

#include <gtest/gtest.h>

#include "palpate/core/units.h"
#include "palpate/sim/board_view.h"
#include "tests/chi_square.h"

namespace palpate::sim {
namespace {

Instant<TrueTime> at(double s) { return Instant<TrueTime>::from_seconds(s); }

TEST(Simulator, TruthIsDrawnBySeedAndStaysTheSame) {
  const auto a = draw_truth(config::reference_world(), 5), b = draw_truth(config::reference_world(), 5);
  const auto c = draw_truth(config::reference_world(), 6);
  EXPECT_EQ(a.joints.gain, b.joints.gain);
  EXPECT_NE(a.joints.gain, c.joints.gain);
  EXPECT_NE(a.tip_in_marker, c.tip_in_marker);
  EXPECT_EQ(a.lengths.l1, c.lengths.l1);  // its sd is 0 in the reference world
  auto still = config::reference_world();
  still.arm.gain_sd = 0.0;
  EXPECT_EQ(draw_truth(still, 5).joints.gain, Vector3(1, 1, 1));
  EXPECT_EQ(draw_truth(still, 5).joints.offset, a.joints.offset);  // others keep their draw
}

TEST(Simulator, AKnockMovesWhatItNamesAndNothingElse) {
  const auto before = draw_truth(config::reference_world(), 5);
  auto world = config::reference_world();
  world.knock.camera = {1e-3, 0.0, 0.0};
  world.knock.base_turn = {0.0, 0.01, 0.0};
  world.knock.tip = {0.0, 0.0, 2e-3};
  world.knock.focus = 0.01;
  world.knock.table = {0.0, 0.0, 5e-3};
  const auto after = draw_truth(world, 5);
  EXPECT_NEAR((after.X_marker_camera.translation - before.X_marker_camera.translation).x(), 1e-3, 1e-15);
  EXPECT_EQ(after.X_marker_camera.rotation.coeffs(), before.X_marker_camera.rotation.coeffs());
  EXPECT_NEAR(after.X_world_base.rotation.angularDistance(before.X_world_base.rotation), 0.01, 1e-12);
  EXPECT_EQ(after.X_world_base.translation, before.X_world_base.translation);
  EXPECT_NEAR((after.tip_in_marker - before.tip_in_marker).z(), 2e-3, 1e-15);
  EXPECT_NEAR((after.X_tip_marker * Point<TipMarker>{after.tip_in_marker}).m.norm(), 0.0, 1e-15);
  EXPECT_EQ(after.pointer_tip, before.pointer_tip);
  EXPECT_NEAR(after.lens.fx / before.lens.fx, 1.01, 1e-12);
  EXPECT_EQ(after.lens.cx, before.lens.cx);
  EXPECT_NEAR((after.landmarks[0].centre - before.landmarks[0].centre).z(), 5e-3, 1e-12);
  EXPECT_NEAR((after.wall[2] - before.wall[2]).z(), 5e-3, 1e-12);
}

// The tracker's first sample of the head's marker; the white noise is another on each visit, the bias is not.
TEST(Simulator, AnotherVisitDrawsNoiseAnewAndKeepsTheSystematicError) {
  const auto first_head = [](std::uint64_t visit, bool white) {
    auto file = config::reference_world();
    if (!white) file.tracker.white_rms = 1e-9;
    Simulator world(file, 5, visit);
    world.advance_to(at(0.1));
    for (const auto& sample : world.tracker().poll())
      if (sample.marker == device::MarkerId::camera_marker && sample.seen) return sample.translation;
    return Vector3(Vector3::Zero());
  };
  EXPECT_EQ(first_head(0, true), first_head(0, true));
  EXPECT_GT((first_head(1, true) - first_head(0, true)).norm(), 1e-6);
  EXPECT_LT((first_head(1, false) - first_head(0, false)).norm(), 1e-7);
}

TEST(Simulator, SpreadOfTheDrawsIsTheStatedOne) {
  double gains = 0.0, mount = 0.0;
  constexpr int kSeeds = 2000;
  for (int seed = 0; seed < kSeeds; ++seed) {
    const auto truth = draw_truth(config::reference_world(), static_cast<std::uint64_t>(seed));
    gains += (truth.joints.gain - Vector3::Ones()).squaredNorm();
    mount += (truth.tip_in_marker - config::reference_world().tip_marker.tip).squaredNorm();
  }
  EXPECT_TRUE(tests::is_chi_square(gains / std::pow(0.012, 2), 3 * kSeeds));
  EXPECT_TRUE(tests::is_chi_square(mount / std::pow(2e-3, 2), 3 * kSeeds));
}

TEST(Simulator, ArmWrittenWithoutFirstOffsetHasTheSameTips) {
  const auto truth = draw_truth(config::reference_world(), 3);
  const auto arm = arm_with_first_offset_zero(truth);
  EXPECT_EQ(arm.joints.offset[0], 0.0);
  Random random(1);
  for (int i = 0; i < 100; ++i) {
    const Vector3 psi(random.uniform(-0.8, 0.8), random.uniform(-0.2, 1.5), random.uniform(-0.4, 1.1));
    const Vector3 gimbal(random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(-1, 1));
    const auto a = truth.X_world_base * device::phantom_pose(truth.joints.apply(psi), gimbal, truth.lengths);
    const auto b = arm.X_world_base * device::phantom_pose(arm.joints.apply(psi), gimbal, arm.lengths);
    EXPECT_LT((a.translation - b.translation).norm(), 1e-14);
    EXPECT_LT(angle_between(a.rotation, b.rotation), 1e-7);
  }
}

TEST(Simulator, ClocksReadOffsetAndDriftAndInvertExactly) {
  Simulator world(config::reference_world(), 1);
  const auto t = at(1000.0);
  EXPECT_EQ(world.arm_clock().at(t).ns(), 1'012'500'000'000 + 15'000'000);    // 12.5 s, 15 ppm of 1000 s
  EXPECT_EQ(world.tracker_clock().at(t).ns(), 996'250'000'000 - 40'000'000);  // -3.75 s, -40 ppm
  EXPECT_EQ(world.graphics_clock().at(t).ns(), 1'001'234'567'000 + 80'000'000);
  for (double s : {0.0, 0.001, 17.3, 86400.0}) {
    EXPECT_LE(std::abs((world.camera_clock().true_time(world.camera_clock().at(at(s))) - at(s)).count()), 1);
  }
}

TEST(Simulator, TrackerSamplesComeLateWithTheirOwnStamps) {
  Simulator world(config::reference_world(), 1);
  world.advance_to(at(0.0199));
  EXPECT_TRUE(world.tracker().poll().empty());  // the first frame, of 0.01 s, is on its way for 10 ms
  world.advance_to(at(0.0201));
  const auto samples = world.tracker().poll();
  ASSERT_EQ(samples.size(), 2u);  // stylus and head; the pointer is put down
  EXPECT_EQ(samples[0].stamp, world.tracker_clock().at(at(0.01)));
  EXPECT_EQ(samples[0].waited, std::chrono::microseconds(100));
  world.advance_to(at(1.0));
  EXPECT_EQ(world.tracker().poll().size(), 2u * 98u);
}

TEST(Simulator, MarkersInUseAreSeen) {
  Simulator world(config::reference_world(), 2);
  world.advance_to(at(3.0));
  int tip = 0, head = 0, frames = 0;
  for (const auto& sample : world.tracker().poll()) {
    if (sample.marker == device::MarkerId::tip_marker) tip += sample.seen;
    if (sample.marker == device::MarkerId::camera_marker) {
      head += sample.seen;
      ++frames;
    }
  }
  EXPECT_GT(tip, 0.97 * frames);
  EXPECT_GT(head, 0.97 * frames);
}

TEST(Simulator, IsTheSameHoweverTimeIsCutIntoPieces) {
  const auto run = [](double piece) {
    Simulator world(config::reference_world(), 9);
    device::HandTarget target;
    target.tip.m = Vector3(0.05, -1.35, 1.75);
    world.hand().move_to(target);
    for (double t = piece; t < 0.5 + 1e-9; t += piece) world.advance_to(at(t));
    world.advance_to(at(0.5));
    std::vector<double> all;
    for (const auto& sample : world.tracker().poll())
      if (sample.seen)
        all.insert(all.end(), {sample.translation.x(), sample.rotation.z(), sample.covariance(1, 4)});
    const auto arm = world.arm().read();
    all.insert(all.end(), arm.joints.begin(), arm.joints.end());
    all.insert(all.end(), arm.gimbal.begin(), arm.gimbal.end());
    return all;
  };
  const auto whole = run(0.5);
  EXPECT_EQ(whole, run(0.001));
  EXPECT_EQ(whole, run(0.0137));
  EXPECT_GT(whole.size(), 100u);
}

TEST(Simulator, TimeNeverGoesBack) {
  Simulator world(config::reference_world(), 1);
  world.advance_to(at(1.0));
  world.advance_to(at(0.5));
  EXPECT_EQ(world.now(), at(1.0));
  EXPECT_EQ(world.physics_clock().now().ns(), 1'000'000'000);
  world.physics_clock().sleep_until(Instant<PhysicsClock>::from_seconds(1.25));
  EXPECT_EQ(world.now(), at(1.25));
}

TEST(Simulator, HandBringsTheStylusToThePlayersTarget) {
  Simulator world(config::reference_world(), 4);
  device::HandTarget target;
  target.tip.m = Vector3(0.0, -1.35, 1.80);
  target.R_world_tip = so3_exp({-0.5, 0.2, 0.0});
  world.hand().move_to(target);
  world.advance_to(at(0.1));
  EXPECT_GT((world.true_state().X_world_tip.translation - target.tip.m).norm(),
            0.01);  // a hand takes its time
  world.advance_to(at(1.5));
  // Dry friction of 0.04 N against 250 N/m leaves up to 0.16 mm.
  EXPECT_LT((world.true_state().X_world_tip.translation - target.tip.m).norm(), 0.3e-3);
  EXPECT_LT(angle_between(world.true_state().X_world_tip.rotation, target.R_world_tip), 1e-3);
}

TEST(Simulator, ReadingsThroughTheTrueArmGiveTheTrueTip) {
  Simulator world(config::reference_world(), 4);
  device::HandTarget target;
  target.tip.m = Vector3(0.15, -1.30, 1.72);
  world.hand().move_to(target);
  world.advance_to(at(1.0));
  const auto& truth = world.truth();
  const auto sample = world.arm().read();
  const auto tip =
      truth.X_world_base * device::phantom_pose(truth.joints.apply(sample.joints),
                                                truth.gimbal.apply(sample.gimbal), truth.lengths);
  EXPECT_LT((tip.translation - world.true_state().X_world_tip.translation).norm(),
            0.06e-3);  // encoder class 0.03 mm
  EXPECT_LT(angle_between(tip.rotation, world.true_state().X_world_tip.rotation), 3e-3);
}

TEST(Simulator, CameraStampsMidExposureAndArrivesLate) {
  auto file = config::reference_world();
  file.camera.drop = 0.0;
  Simulator world(file, 1);
  int drawn = 0;
  world.set_renderer([&](const TrueView& view, std::vector<std::uint8_t>& rgb) {
    ++drawn;
    rgb.assign(static_cast<std::size_t>(view.lens.width * view.lens.height * 3), 7);
  });
  world.advance_to(at(0.5 / 30.0 + 0.0399));
  EXPECT_FALSE(world.camera().poll());
  world.advance_to(at(0.5 / 30.0 + 0.0401));
  const auto image = world.camera().poll();
  ASSERT_TRUE(image);
  EXPECT_EQ(image->mid_exposure, world.camera_clock().at(at(0.5 / 30.0)));
  EXPECT_EQ(image->frame, 0u);
  EXPECT_EQ(image->rgb.size(), 640u * 480u * 3u);
  world.advance_to(at(1.0));
  const auto newest = world.camera().poll();
  ASSERT_TRUE(newest);
  EXPECT_EQ(drawn, 2);  // older ones were never drawn
  EXPECT_GT(newest->frame, 25u);
}

TEST(Simulator, AnImageNobodyLooksAtIsNotDrawnAndChangesNoOther) {
  const auto second_image = [](bool look_at_first, int& drawn) {
    Simulator world(config::reference_world(), 1);
    world.set_renderer([&](const TrueView& view, std::vector<std::uint8_t>& rgb) {
      ++drawn;
      rgb.assign(8, static_cast<std::uint8_t>(view.noise_seed));
    });
    world.advance_to(at(0.1));
    const auto first = look_at_first ? world.camera().poll() : world.camera().poll_unseen();
    EXPECT_TRUE(first && first->rgb.empty() != look_at_first && first->width == 640);
    world.advance_to(at(0.2));
    return world.camera().poll();
  };
  int drawn = 0, drawn_unseen = 0;
  const auto after_seen = second_image(true, drawn), after_unseen = second_image(false, drawn_unseen);
  EXPECT_EQ(drawn, 2);
  EXPECT_EQ(drawn_unseen, 1);
  ASSERT_TRUE(after_seen && after_unseen);
  EXPECT_EQ(after_seen->frame, after_unseen->frame);
  EXPECT_EQ(after_seen->mid_exposure, after_unseen->mid_exposure);
  EXPECT_EQ(after_seen->rgb, after_unseen->rgb);
}

TEST(Simulator, DroppedFramesLeaveGapsInTheCount) {
  auto file = config::reference_world();
  file.camera.drop = 0.3;
  Simulator world(file, 1);
  std::vector<std::uint64_t> frames;
  for (int i = 1; i <= 3000; ++i) {
    world.advance_to(at(i * 0.01));
    if (const auto image = world.camera().poll()) frames.push_back(image->frame);
  }
  const double share = 1.0 - static_cast<double>(frames.size()) / static_cast<double>(frames.back() + 1);
  EXPECT_NEAR(share, 0.3, 0.06);  // 900 frames: sd 0.015
}

TEST(Simulator, CamerasTakeOtherPicturesAtAnotherRateAndCountOn) {
  auto file = config::reference_world();
  file.camera.drop = 0.0;
  Simulator world(file, 1);
  world.advance_to(at(1.0));
  const auto before = world.camera().poll_unseen();
  world.set_camera_rate(10.0);
  std::vector<device::CameraImage> images;
  for (int i = 1; i <= 400; ++i) {
    world.advance_to(at(1.0 + i * 0.0025));
    if (auto image = world.camera().poll_unseen()) images.push_back(std::move(*image));
  }
  ASSERT_TRUE(before);
  ASSERT_GE(images.size(), 10u);
  EXPECT_LE(images.size(), 12u);
  std::uint64_t frame = before->frame;
  for (std::size_t i = 0; i < images.size(); ++i) {
    EXPECT_EQ(images[i].frame, ++frame);
    // The clock's drift is some millionths; what was exposed or due before the change came at 30 a second.
    if (i > 2) {
      EXPECT_NEAR(to_seconds(images[i].mid_exposure - images[i - 1].mid_exposure), 0.1, 1e-4);
    }
  }
}

TEST(Simulator, RollingShutterLooksBandByBand) {
  auto file = config::reference_world();
  file.camera.shutter = "rolling";
  file.camera.readout_s = 0.020;
  file.camera.drop = 0.0;
  Simulator world(file, 1);
  std::vector<Quaternion> views;
  world.set_renderer([&](const TrueView& view, std::vector<std::uint8_t>& rgb) {
    views.push_back(view.X_world_camera.rotation);
    rgb.assign(static_cast<std::size_t>(view.lens.width * view.lens.height * 3),
               static_cast<std::uint8_t>(views.size()));
  });
  world.advance_to(at(0.2));
  const auto image = world.camera().poll();
  ASSERT_TRUE(image);
  ASSERT_EQ(views.size(), static_cast<std::size_t>(SimulatedCamera::kRollingBands));
  EXPECT_EQ(image->rgb.front(), 1);
  EXPECT_EQ(image->rgb.back(), SimulatedCamera::kRollingBands);
  EXPECT_GT(angle_between(views.front(), views.back()), 1e-3);  // the head turned meanwhile
}

TEST(Simulator, HeadTurnsWithTheStatedPeakSpeedAndMovesSmoothly) {
  auto file = config::reference_world();
  file.head.shake = 0.0;
  Simulator world(file, 1);
  double peak = 0.0;
  for (double t = 0.0; t < 2.5; t += 0.005)
    peak = std::max(peak, angle_between(world.true_camera_at(at(t)).rotation,
                                        world.true_camera_at(at(t + 1e-3)).rotation) /
                              1e-3);
  EXPECT_NEAR(degrees_from_radians(peak), 50.0, 1.0);
}

TEST(Simulator, LandmarksLieOnTableAndWallInViewOfTheHead) {
  Simulator world(config::reference_world(), 1);
  const auto& truth = world.truth();
  ASSERT_EQ(truth.landmarks.size(), 12u);
  int seen = 0;
  const auto X_camera_world = world.true_camera_at(at(0.0)).inverse();
  for (const auto& dot : truth.landmarks) {
    const bool on_table = std::abs(dot.centre.y() + 1.52) < 1e-9,
               on_wall = std::abs(dot.centre.z() - 0.80) < 1e-9;
    EXPECT_TRUE(on_table || on_wall);
    const Vector3 p = (X_camera_world * Point<palpate::World>{dot.centre}).m;
    const device::Pixel u = truth.lens.project(p);
    seen += p.z() > 0 && u.x() > 5 && u.x() < 634 && u.y() > 5 && u.y() < 474;
  }
  EXPECT_GE(seen, 10);
}

TEST(BoardView, WholeBoardsOnly) {
  const auto lens = draw_truth(config::reference_world(), 1).lens;
  Random random(3);
  const auto poses = board_poses(lens, 15, random);
  ASSERT_EQ(poses.size(), 15u);
  for (const auto& pose : poses) {
    const auto corners = board_corners(lens, pose, 0.0, random);
    ASSERT_TRUE(corners);
    EXPECT_EQ(corners->size(), 54u);
  }
  const Pose<CameraOptical, Board> beside{Quaternion::Identity(), {0.5, 0, 0.4}};
  EXPECT_FALSE(board_corners(lens, beside, 0.0, random));
  const Pose<CameraOptical, Board> behind{Quaternion::Identity(), {0, 0, -0.4}};
  EXPECT_FALSE(board_corners(lens, behind, 0.0, random));
}

// The check of the forces needs them apart, and the arm reaches all of them.
TEST(SimulatedPerson, HoldsTheStylusInFivePlacesAHandsBreadthApart) {
  Simulator world(config::reference_world(), 3);
  std::vector<Vector3> held;
  for (int i = 0; i < 5; ++i) {
    ASSERT_TRUE(world.person().ask({device::Gesture::hold, "", i}));
    for (int ms = 0; ms < 6000 && !*world.person().ready(); ++ms)
      world.advance_to(world.now() + std::chrono::milliseconds(1));
    ASSERT_TRUE(*world.person().ready()) << i;
    held.push_back(world.true_state().X_world_tip.translation);
    for (int k = 0; k < i; ++k)
      EXPECT_GT((held[static_cast<std::size_t>(i)] - held[static_cast<std::size_t>(k)]).norm(), 0.075)
          << i << " " << k;
  }
  EXPECT_GT(held[1].y(), held[0].y() + 0.04);
  EXPECT_LT(held[1].x(), held[0].x() - 0.06);
  EXPECT_LT(held[4].y(), held[0].y() - 0.04);
  EXPECT_GT(held[4].x(), held[0].x() + 0.06);
}

}  // namespace
}  // namespace palpate::sim
