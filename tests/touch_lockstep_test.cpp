#include <gtest/gtest.h>

#include "applications/touch/record.h"
#include "applications/touch/specification.h"
#include "applications/touch/touch.h"
#include "palpate/server/physics/physics_server.h"
#include "palpate/sim/config/world_scene.h"
#include "palpate/sim/lockstep/lockstep_play.h"
#include "palpate/sim/truth_rig.h"

namespace palpate {
namespace {

// The whole chain on the virtual clock: simulated hand, arm with friction and encoders, calibrated
// kinematics, haptic loop with its limits, physics loop, and the force back through the motors.
TEST(TouchInLockstep, AHandThatPressesOnTheOrganComesToRestAndOneThatStrokesItFeelsItAllTheWay) {
  sim::Simulator world(sim::config::reference_world(), 3);
  const rig::Rig rig = sim::truth_rig(world);
  const auto scene = server::physics::scene_from_rig(
      rig, *sim::config::scene_of(world.file(), {applications::touch::specification()}, "touch"));
  auto application = scene::ApplicationRegistry{applications::touch::specification()}.make_physics(scene, {});
  ASSERT_TRUE(application) << application.error().message;
  auto& touch = dynamic_cast<applications::touch::TouchApplication&>(**application);
  server::physics::PhysicsServer server(
      rig, scene, std::move(*application), world.arm(),
      haptics::HapticSettings{.permit = haptics::ForcePermit::of_simulated_arm()});

  const Vector3 top = touch.rest().translation + Vector3(0.0, 0.040, 0.01);
  const auto start = world.now();
  constexpr Duration kStep = std::chrono::milliseconds(1);
  Vector3 low = Vector3::Constant(1e9), high = -low;
  int strokes = 0, felt = 0;
  for (int i = 0; i < 9000; ++i) {
    const double t = i * 1e-3;
    device::HandTarget target;
    target.tip.m = top + Vector3(0, 0.03, 0);
    if (t > 2.0) target.tip.m.y() -= 0.034 * std::min(1.0, (t - 2.0) / 0.5);
    if (t > 6.0) target.tip.m.x() += 0.010 * std::sin(3.0 * (t - 6.0));
    world.hand().move_to(target);
    world.advance_to(start + (i + 1) * kStep);
    const Instant<PhysicsClock> now{world.now().since_epoch};
    server.haptic_tick(now);
    server.physics_tick(now);
    const Vector3 tip = world.true_state().X_world_tip.translation;
    if (t > 5.0 && t <= 6.0) {
      low = low.cwiseMin(tip);
      high = high.cwiseMax(tip);
    }
    if (t > 6.0) {
      ++strokes;
      felt += touch.proxy().touching;
    }
  }
  EXPECT_LT((high - low).norm(), 1e-4) << "a tenth of a millimetre in a second: three steps of the encoders";
  EXPECT_EQ(felt, strokes);
  EXPECT_GT(server.haptic().statistics().peak_n, 0.3);
  EXPECT_EQ(server.haptic().statistics().rejected_impacts, 0u);
  EXPECT_EQ(server.newest().counters[applications::touch::kUnsettled], 0);
}

// The player in front of the picture, through cameras, network, clocks and motors, and back into the picture.
TEST(TouchInLockstep, TheScriptedPlayerExploresThroughTheWholeSystem) {
  sim::Simulator world(sim::config::reference_world(), 5);
  const rig::Rig rig = sim::truth_rig(world);
  const auto scene = server::physics::scene_from_rig(
      rig, *sim::config::scene_of(world.file(), {applications::touch::specification()}, "touch"));
  sim::lockstep::LockstepOptions options;
  options.applications = {applications::touch::specification()};
  options.seconds = 8.0;
  options.seed = 5;
  applications::touch::TouchRecord record;
  options.watch = [&record](const scene::SceneState& state) { record.add_state(state); };
  const auto play = sim::lockstep::play_in_lockstep(world, rig, scene, options, {}, {});
  ASSERT_TRUE(play) << play.error().message;
  const Json summary = record.summary()["touch"];
  EXPECT_NEAR(summary["of_s"].get<double>(), 8.0, 0.01);
  EXPECT_GE(summary["touches"].get<int>(), 1);
  EXPECT_GT(summary["contact_s"].get<double>(), 2.0);
  EXPECT_GE(summary["slips"].get<int>(), 1);
  EXPECT_NEAR(summary["friction"]["median"].get<double>(), 0.3, 0.03) << "as the scene says";
  EXPECT_LT(summary["depth_mm"]["max"].get<double>(), 10.0);
  EXPECT_LT(summary["unsettled"].get<int>(), 40) << "of 8000";
  EXPECT_GT(play->haptics.size(), 2000u) << "a lasting force is recorded while it lasts";
  EXPECT_GT(play->haptic.peak_n, 0.5);
  EXPECT_EQ(play->haptic.fault_ticks, 0u);
}

}  // namespace
}  // namespace palpate
