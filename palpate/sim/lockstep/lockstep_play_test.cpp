#include "palpate/sim/lockstep/lockstep_play.h"
#include "palpate/sim/config/world_scene.h"

#include <gtest/gtest.h>

#include <memory>
#include <optional>
#include <stdexcept>

#include "applications/pingpong/pingpong.h"
#include "applications/pingpong/specification.h"
#include "palpate/core/statistics.h"
#include "palpate/scene/shown_tip.h"
#include "palpate/server/physics/physics_server.h"
#include "palpate/sim/truth_rig.h"

namespace palpate::sim::lockstep {
namespace {

LockstepResult play(double play_seconds, const LockstepOptions& base = {}, std::uint64_t seed = 3) {
  Simulator world(config::reference_world(), seed);
  const rig::Rig rig = truth_rig(world);
  const auto scene = server::physics::scene_from_rig(
      rig, *sim::config::scene_of(world.file(), {applications::pingpong::specification()}, "pingpong"));
  LockstepOptions options = base;
  options.applications = {applications::pingpong::specification()};
  options.seconds = play_seconds;
  options.seed = seed;
  auto result = play_in_lockstep(world, rig, scene, options, {}, {});
  EXPECT_TRUE(result.has_value()) << result.error().message;
  return *result;
}

// Throws a second after the play has begun.
class Thrower final : public scene::Application {
 public:
  void step(Instant<PhysicsClock> now, Duration, const scene::TipState&, scene::SceneState&) override {
    if (!began_) began_ = now;
    if (to_seconds(now - *began_) >= 1.0) throw std::runtime_error("the net fell off");
  }
  const scene::ImpactEvent& impact() const override { return none_; }

 private:
  void begin() override {}
  void reset() override {}
  std::optional<Instant<PhysicsClock>> began_;
  scene::ImpactEvent none_;
};

TEST(LockstepPlay, EndsInWordsWhereTheApplicationThrows) {
  Simulator world(config::reference_world(), 3);
  const rig::Rig rig = truth_rig(world);
  auto spec = applications::pingpong::specification();
  spec.make_physics = [](const scene::SceneDescription&, const scene::RunSettings&) {
    return std::make_unique<Thrower>();
  };
  LockstepOptions options;
  options.applications = {spec};
  options.seconds = 2.0;
  const auto scene = server::physics::scene_from_rig(
      rig, *sim::config::scene_of(world.file(), options.applications, "pingpong"));
  const auto result = play_in_lockstep(world, rig, scene, options, {}, {});
  ASSERT_FALSE(result);
  EXPECT_NE(result.error().message.find("the application 'pingpong' threw: the net fell off"),
            std::string::npos)
      << result.error().message;
  EXPECT_NE(result.error().message.find("1.0"), std::string::npos) << result.error().message;  // when
}

TEST(LockstepPlay, ThePlayerReturnsMostServesAndForcesStayWithinTheArmsLimits) {
  for (std::uint64_t seed = 3; seed <= 4; ++seed) {
    const auto result = play(30.0, {}, seed);
    const auto& counters = result.final_state.counters;
    EXPECT_GE(counters[applications::pingpong::kServes], 22);
    EXPECT_GE(counters[applications::pingpong::kReturned], 0.8 * counters[applications::pingpong::kServes]);
    EXPECT_GE(counters[applications::pingpong::kLongest], 3);
    EXPECT_GT(result.haptic.peak_n, 0.5);
    EXPECT_LE(result.haptic.peak_n, 8.5);
    // Never into the stops, never too fast: no force is cut, so no impact is lost.
    EXPECT_EQ(result.haptic.ticks, 30'000u) << "the warm-up is not counted";
    EXPECT_EQ(result.haptic.fault_ticks, 0u);
    EXPECT_LT(result.haptic.lost_impulse_rel(), 1e-9);
    RecordProperty("serves", counters[applications::pingpong::kServes]);
    RecordProperty("returned", counters[applications::pingpong::kReturned]);
  }
}

TEST(LockstepPlay, ATenthOfASecondMoreMakesThePlayClearlyWorse) {
  double now = 0.0, later = 0.0;
  for (std::uint64_t seed = 5; seed <= 6; ++seed) {
    const auto share = [seed](double extra_delay_s) {
      LockstepOptions options;
      options.player_extra_delay_s = extra_delay_s;
      const auto counters = play(30.0, options, seed).final_state.counters;
      return static_cast<double>(counters[applications::pingpong::kReturned]) /
             counters[applications::pingpong::kServes];
    };
    now += 0.5 * share(0.0);
    later += 0.5 * share(0.100);
  }
  EXPECT_LT(later, now - 0.15);
}

TEST(LockstepPlay, TheDrawnTipStandsWhereTheRealOneIs) {
  const auto result = play(6.0);
  Simulator world(config::reference_world(), 3);
  const auto scene =
      *sim::config::scene_of(world.file(), {applications::pingpong::specification()}, "pingpong");
  ErrorSummary tip_mm;
  for (const auto& frame : result.frames)
    tip_mm.add(1e3 * (scene::shown_tip(frame.record.state, scene) - frame.true_tip).norm());
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

TEST(LockstepPlay, FramesPassedOnAreThoseThatAreKeptOtherwise) {
  const auto kept = play(4.0);
  LockstepOptions options;
  std::vector<Vector3> tips;
  std::size_t trips = 0;
  options.pass_on = [&](const LockstepFrame& frame) {
    ASSERT_LT(tips.size(), kept.frames.size());
    EXPECT_EQ(frame.sync_error_s, kept.sync_errors_s[tips.size()]);
    EXPECT_LE(std::abs(frame.sync_error_s), frame.sync_uncertainty_s);
    tips.push_back(frame.played.true_tip);
    trips += frame.round_trips_s.size();
  };
  const auto passed = play(4.0, options);
  ASSERT_EQ(tips.size(), kept.frames.size());
  for (std::size_t i = 0; i < tips.size(); ++i) EXPECT_EQ(tips[i], kept.frames[i].true_tip);
  EXPECT_EQ(trips + passed.round_trips_s.size(), kept.round_trips_s.size());
  EXPECT_TRUE(passed.frames.empty());
  EXPECT_TRUE(passed.haptics.empty());
  EXPECT_EQ(passed.haptic.peak_n, kept.haptic.peak_n);
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
}  // namespace palpate::sim::lockstep
