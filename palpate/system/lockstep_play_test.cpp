#include "palpate/system/lockstep_play.h"

#include <gtest/gtest.h>

#include "palpate/applications/pingpong/pingpong.h"
#include "palpate/physics_server/physics_server.h"
#include "palpate/system/scene_settings.h"
#include "palpate/system/truth_rig_for_tests.h"

namespace palpate {
namespace {

LockstepResult play(double play_seconds, const LockstepOptions& base = {}, std::uint64_t seed = 3) {
  sim::SimWorld world(sim::reference_world(), seed);
  const Rig rig = truth_rig(world);
  const auto scene =
      scene_from_rig(rig, scene_settings(world.file(), "pingpong"), world.file().ball.restitution_table);
  LockstepOptions options = base;
  options.seconds = play_seconds;
  options.seed = seed;
  auto result = play_in_lockstep(world, rig, scene, options, {}, {});
  EXPECT_TRUE(result.has_value()) << result.error().message;
  return *result;
}

TEST(LockstepPlay, ThePlayerReturnsMostServesAndForcesStayWithinTheArmsLimits) {
  const auto result = play(30.0);
  const auto& counters = result.final_state.counters;
  EXPECT_GE(counters[pingpong::kServes], 20);
  EXPECT_GE(counters[pingpong::kReturned], 0.6 * counters[pingpong::kServes]);
  EXPECT_GT(result.haptic.peak_n, 0.5);
  EXPECT_LE(result.haptic.peak_n, 8.5);
  // Blows during the ramp after an overspeed fault are lost, and counted; without a fault nothing is.
  EXPECT_LT(result.haptic.lost_impulse_rel(), 0.3);
  RecordProperty("serves", counters[pingpong::kServes]);
  RecordProperty("returned", counters[pingpong::kReturned]);
}

TEST(LockstepPlay, TheDrawnTipStandsWhereTheRealOneIs) {
  const auto result = play(6.0);
  sim::SimWorld world(sim::reference_world(), 3);
  const auto scene = scene_settings(world.file(), "pingpong");
  ErrorSummary tip_mm;
  for (const auto& frame : result.frames)
    tip_mm.add(1e3 * (shown_tip(frame.record.state, scene) - frame.true_tip).norm());
  ASSERT_GT(tip_mm.count(), 150u);
  // Calibration is perfect here: what is left is time (a millisecond at 1 m/s is a millimetre) and encoder
  // steps.
  EXPECT_LT(tip_mm.rms(), 0.5);
  for (double e : result.sync_errors_s) EXPECT_LT(std::abs(e), 50e-6);
}

TEST(LockstepPlay, TheSameSeedGivesTheSamePlayToTheBit) {
  const auto a = play(4.0), b = play(4.0);
  ASSERT_EQ(a.frames.size(), b.frames.size());
  for (std::size_t i = 0; i < a.frames.size(); ++i) {
    EXPECT_EQ(a.frames[i].record.state.bodies[0].position, b.frames[i].record.state.bodies[0].position);
    EXPECT_EQ(a.frames[i].record.X_world_camera.translation, b.frames[i].record.X_world_camera.translation);
  }
  EXPECT_EQ(a.haptic.peak_n, b.haptic.peak_n);
}

TEST(LockstepPlay, LostRepliesMeanThePreviousStateAndAreCounted) {
  LockstepOptions options;
  options.channel.loss = 0.2;
  const auto result = play(6.0, options);
  int late = 0;
  for (const auto& frame : result.frames) late += frame.record.late ? 1 : 0;
  EXPECT_GT(late, 20);
  EXPECT_LT(late, static_cast<int>(result.frames.size()) / 2);
  EXPECT_GT(result.exchange.lost + result.exchange.unsent, 20u);
}

}  // namespace
}  // namespace palpate
