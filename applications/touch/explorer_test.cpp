// Exploring in a test: the application, a soft hand, and a player that sees late.
#include "applications/touch/explorer.h"

#include <gtest/gtest.h>

#include "applications/touch/organ_for_tests.h"
#include "palpate/scene/soft_hand_for_tests.h"

namespace palpate::applications::touch {
namespace {

struct Exploration {
  int touches = 0, slips = 0, contact_ms = 0, unsettled = 0;
  double peak = 0.0, mean_force = 0.0, deepest = 0.0, hardest = 0.0, highest = -1e9;
  Vector3 last = Vector3::Zero();
};

Exploration explore(const scene::SceneDescription& scene, double for_s, std::uint64_t seed,
                    double extra_delay_s = 0.0) {
  using SoftHand = scene::SoftHand<TouchApplication>;
  TouchApplication application(scene);
  const scene::Reach reach = SoftHand::reach();
  scene::PlayerSettings settings = SoftHand::player_settings(seed);
  settings.reaction_s += extra_delay_s;
  Explorer player(scene, reach, settings);
  SoftHand hand(application, reach.home());

  Exploration result;
  Vector3 target_velocity = Vector3::Zero();
  double sum = 0.0;
  int felt = 0;
  for (int i = 1; i * SoftHand::kTick <= for_s; ++i) {
    const auto now = hand.next();
    if (i % 33 == 0) player.show(hand.state, now + seconds(0.05));
    const device::HandTarget target = player.act(now);
    result.hardest = std::max(result.hardest, (target.velocity - target_velocity).norm() / SoftHand::kTick);
    target_velocity = target.velocity;
    hand.follow(target);
    const auto& state = hand.state;
    result.peak = std::max(result.peak, hand.force.norm());
    result.deepest = std::max(result.deepest, 1e-6 * state.counters[kDepthUm]);
    if (state.continuous.touching != 0) {
      sum += hand.force.norm();
      ++felt;
    }
  }
  const auto& state = hand.state;
  result.touches = state.counters[kTouches];
  result.slips = state.counters[kSlips];
  result.contact_ms = state.counters[kContactMs];
  result.unsettled = state.counters[kUnsettled];
  result.mean_force = felt > 0 ? sum / felt : 0.0;
  result.last = hand.x;
  return result;
}

TEST(Explorer, TouchesAgainAndAgainAndStrokesWithTheForceItLikes) {
  for (const std::uint64_t seed : {1u, 2u, 3u}) {
    const auto e = explore(organ_on_table(), 30.0, seed);
    EXPECT_GE(e.touches, 3) << "rounds of up to nine seconds";
    EXPECT_GT(e.contact_ms, 10'000) << "a third of the time at least";
    EXPECT_GT(e.slips, 3) << "it sticks at the ends of a stroke";
    EXPECT_NEAR(e.mean_force, 0.8, 0.5) << "0.8 N is what it wants";
    EXPECT_LT(e.peak, 5.0);
    EXPECT_LT(e.deepest, 0.010);
    EXPECT_LT(e.unsettled, 0.005 * e.contact_ms) << "the rest of the way is gone in the next tick";
    EXPECT_LE(e.hardest, 30.0 * (1.0 + 1e-9)) << "m/s^2, its own bound";
  }
}

TEST(Explorer, TheSameSeedExploresTheSame) {
  const auto a = explore(organ_on_table(), 6.0, 4), b = explore(organ_on_table(), 6.0, 4);
  EXPECT_EQ(a.last, b.last);
  EXPECT_EQ(a.peak, b.peak);
  EXPECT_NE(a.last, explore(organ_on_table(), 6.0, 5).last);
}

// A person had the stylus and gives it back, elsewhere and on the move.
TEST(Explorer, TakesTheHandOverWhereItIs) {
  scene::Reach reach;
  reach.X_world_base = {rotation_from_xyz({0.0262, -0.0698, 0.0140}), {0.10, -1.40, 1.75}};
  const scene::PlayerSettings settings;
  Explorer player(organ_on_table(), reach, settings);
  const auto at = [](double t) { return Instant<PhysicsClock>::from_seconds(t); };
  for (int ms = 0; ms < 500; ++ms) player.act(at(10.0 + 1e-3 * ms));
  const device::HandTarget left{
      {reach.home() + Vector3(0.06, 0.03, -0.05)}, Vector3(0.2, 0.0, 0.1), Quaternion::Identity()};
  player.take_over(left, at(20.0));
  device::HandTarget before = player.act(at(20.0));
  EXPECT_LT((before.tip.m - left.tip.m).norm(), 1e-9);
  for (int ms = 1; ms <= 2000; ++ms) {
    const device::HandTarget target = player.act(at(20.0 + 1e-3 * ms));
    EXPECT_LE((target.velocity - before.velocity).norm() / 1e-3, settings.max_acceleration * (1.0 + 1e-6));
    before = target;
  }
  EXPECT_LT((before.tip.m - reach.home()).norm(), 1e-3) << "it has seen nothing to touch";
}

TEST(Explorer, LeavesAloneWhatItsArmDoesNotReach) {
  const auto scene = with(organ_on_table(), "touch.shift_mm", std::vector<double>{0.0, 0.0, -600.0});
  const auto e = explore(scene, 4.0, 1);
  EXPECT_EQ(e.touches, 0);
  EXPECT_EQ(e.peak, 0.0);
}

}  // namespace
}  // namespace palpate::applications::touch
