#include "palpate/server/graphics/pose_feed.h"

#include <gtest/gtest.h>

#include "applications/pingpong/specification.h"
#include "drivers/openigtlink/codec.h"
#include "palpate/server/physics/physics_server.h"
#include "palpate/sim/config/world_scene.h"
#include "palpate/sim/lockstep/lockstep_play.h"
#include "palpate/sim/truth_rig.h"

namespace palpate::sim::lockstep {
namespace {

const drivers::network::RigidPose* pose_named(const std::vector<server::graphics::LivePose>& poses,
                                              const std::string& name) {
  for (const auto& pose : poses)
    if (pose.name == name) return &pose.pose;
  return nullptr;
}

TEST(PoseFeed, WhatIsPublishedStandsWhereTheTruthIs) {
  Simulator world(config::reference_world(), 3);
  const rig::Rig rig = truth_rig(world);
  const auto scene = server::physics::scene_from_rig(
      rig, *sim::config::scene_of(world.file(), {applications::pingpong::specification()}, "pingpong"));
  LockstepOptions options;
  options.applications = {applications::pingpong::specification()};
  options.seconds = 4.0;
  int tips = 0, cameras = 0, balls = 0;
  options.pass_on = [&](const LockstepFrame& frame) {
    const auto& played = frame.played;
    const auto poses = server::graphics::live_poses(played.record, scene, {}, {});
    for (const auto& pose : poses) EXPECT_LE(pose.name.size(), drivers::openigtlink::kNameBytes);
    if (const auto* tip = pose_named(poses, "TipToWorld")) {
      ++tips;
      // Encoder steps and half a millisecond at the hand's speed; the bat's disc is where the scene says.
      EXPECT_LT((tip->translation - played.true_tip).norm(), 2e-3);
      const auto* bat = pose_named(poses, "BatToWorld");
      ASSERT_NE(bat, nullptr);
      EXPECT_LT((tip->translation + tip->rotation * scene.carried_offset - bat->translation).norm(), 1e-9);
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
  server::graphics::FrameRecord frame;
  EXPECT_TRUE(server::graphics::live_poses(frame, {}, {}, {}).empty());
  frame.have_state = true;
  frame.state.body_count = 2;
  frame.state.bodies[0].visible = 0;
  scene::SceneDescription scene;
  scene.bodies = {{"Ball", 0.1}, {"Bat", 0.2}, {"Beyond", 0.3}};
  const auto poses = server::graphics::live_poses(frame, scene, {}, {});
  EXPECT_NE(pose_named(poses, "BatToWorld"), nullptr) << "what is carried is where the tip is";
  EXPECT_EQ(pose_named(poses, "BeyondToWorld"), nullptr) << "the state has two bodies";
  EXPECT_NE(pose_named(poses, "TipToWorld"), nullptr);
  EXPECT_EQ(pose_named(poses, "BallToWorld"), nullptr);
  EXPECT_EQ(pose_named(poses, "CameraToWorld"), nullptr);
}

TEST(PoseFeed, BodiesAreCalledAsTheApplicationSays) {
  server::graphics::FrameRecord frame;
  frame.have_state = true;
  frame.state.body_count = 3;
  for (auto& body : frame.state.bodies) body.visible = 1;
  frame.state.bodies[2].set_p({1.0, 2.0, 3.0});
  scene::SceneDescription scene;
  scene.bodies = {{"", 0.0}, {"Needle", 0.0}, {"Target", 0.0}};
  const auto poses = server::graphics::live_poses(frame, scene, {}, {});
  EXPECT_EQ(pose_named(poses, "ToWorld"), nullptr) << "one without a name is not told of";
  EXPECT_NE(pose_named(poses, "NeedleToWorld"), nullptr);
  ASSERT_NE(pose_named(poses, "TargetToWorld"), nullptr);
  EXPECT_EQ(pose_named(poses, "TargetToWorld")->translation, Vector3(1.0, 2.0, 3.0));
}

TEST(PoseFeed, TheTimeOfAStateIsTheGraphicsHostsOwn) {
  server::graphics::FrameRecord frame;
  frame.have_state = true;
  frame.state.time = Instant<PhysicsClock>::from_seconds(105.0);
  const ClockModel<GraphicsClock, PhysicsClock> sync(Instant<GraphicsClock>::from_seconds(3.0),
                                                     Instant<PhysicsClock>::from_seconds(103.0), 0.0);
  EXPECT_NEAR(server::graphics::live_poses(frame, {}, sync, {})[0].time.seconds(), 5.0, 1e-9);
}

}  // namespace
}  // namespace palpate::sim::lockstep
