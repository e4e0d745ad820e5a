#include "palpate/system/pose_feed.h"

#include <gtest/gtest.h>

#include "palpate/applications/scene_settings.h"
#include "palpate/physics_server/physics_server.h"
#include "palpate/system/lockstep_play.h"
#include "palpate/system/truth_rig_for_tests.h"

namespace palpate {
namespace {

const igtl::RigidPose* pose_named(const std::vector<LivePose>& poses, const std::string& name) {
  for (const auto& pose : poses)
    if (pose.name == name) return &pose.pose;
  return nullptr;
}

TEST(PoseFeed, WhatIsPublishedStandsWhereTheTruthIs) {
  sim::SimWorld world(sim::reference_world(), 3);
  const Rig rig = truth_rig(world);
  const auto scene =
      scene_from_rig(rig, scene_settings(world.file(), "pingpong"), world.file().ball.restitution_table);
  LockstepOptions options;
  options.seconds = 4.0;
  int tips = 0, cameras = 0, balls = 0;
  options.pass_on = [&](const LockstepFrame& frame) {
    const auto& played = frame.played;
    const auto poses = live_poses(played.record, scene, {}, {});
    for (const auto& pose : poses) EXPECT_LE(pose.name.size(), igtl::kNameBytes);
    if (const auto* tip = pose_named(poses, "TipToWorld")) {
      ++tips;
      // Encoder steps and half a millisecond at the hand's speed; the bat's disc is where the scene says.
      EXPECT_LT((tip->translation - played.true_tip).norm(), 2e-3);
      const auto* bat = pose_named(poses, "BatToWorld");
      ASSERT_NE(bat, nullptr);
      EXPECT_LT((tip->translation + tip->rotation * scene.bat_offset - bat->translation).norm(), 1e-9);
    }
    if (const auto* camera = pose_named(poses, "CameraToWorld")) {
      ++cameras;
      // The tracker alone: its noise times the lever of the camera, and the head's way in its latency.
      EXPECT_LT((camera->translation - played.truth.X_world_camera.translation).norm(), 8e-3);
      EXPECT_LT(camera->rotation.angularDistance(played.truth.X_world_camera.rotation), 0.03);
    }
    balls += pose_named(poses, "BallToWorld") != nullptr ? 1 : 0;
  };
  ASSERT_TRUE(play_in_lockstep(world, rig, scene, options, {}, {}).has_value());
  EXPECT_GT(tips, 100);
  EXPECT_GT(cameras, 100);
  EXPECT_GT(balls, 50);
}

TEST(PoseFeed, WhatIsNotKnownOrNotSeenIsNotSent) {
  FrameRecord frame;
  EXPECT_TRUE(live_poses(frame, {}, {}, {}).empty());
  frame.have_state = true;
  frame.state.bodies[0].visible = 0;
  const auto poses = live_poses(frame, {}, {}, {});
  EXPECT_NE(pose_named(poses, "TipToWorld"), nullptr);
  EXPECT_EQ(pose_named(poses, "BallToWorld"), nullptr);
  EXPECT_EQ(pose_named(poses, "CameraToWorld"), nullptr);
}

TEST(PoseFeed, TheTimeOfAStateIsTheGraphicsHostsOwn) {
  FrameRecord frame;
  frame.have_state = true;
  frame.state.time = Instant<PhysicsClock>::from_seconds(105.0);
  const ClockModel<GraphicsClock, PhysicsClock> sync(Instant<GraphicsClock>::from_seconds(3.0),
                                                     Instant<PhysicsClock>::from_seconds(103.0), 0.0);
  EXPECT_NEAR(live_poses(frame, {}, sync, {})[0].time.seconds(), 5.0, 1e-9);
}

}  // namespace
}  // namespace palpate
