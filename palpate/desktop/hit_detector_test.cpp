#include "palpate/desktop/hit_detector.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace palpate::desktop {
namespace {

constexpr double kMass = 0.0027;
const std::vector<double> kMasses{kMass};

scene::SceneState at(int ms, const Vector3& p, const Vector3& v, std::uint32_t jumps) {
  scene::SceneState state;
  state.time = Instant<PhysicsClock>{} + std::chrono::milliseconds(ms);
  state.body_count = 1;
  state.bodies[0].set_p(p);
  state.bodies[0].set_v(v);
  state.bodies[0].jumps = jumps;
  return state;
}

TEST(HitDetector, HearsABounceWithTheImpulseOfTheVelocitysJump) {
  HitDetector detector(kMasses);
  EXPECT_FALSE(detector.look(at(0, {0, 0.003, 0}, {1, -2, 0}, 5)));
  EXPECT_FALSE(detector.look(at(1, {0.001, 0.001, 0}, {1, -2, 0}, 5)));
  const auto hit = detector.look(at(2, {0.002, 0.001, 0}, {1, 1.86, 0}, 6));
  ASSERT_TRUE(hit);
  EXPECT_EQ(hit->kind, HitKind::body);
  EXPECT_NEAR(hit->impulse, kMass * 3.86, 1e-12);
  EXPECT_FALSE(detector.look(at(3, {0.003, 0.003, 0}, {1, 1.85, 0}, 6)));
}

TEST(HitDetector, HearsABodyByItsMassAndNoneThatHasNone) {
  for (const double mass : {0.0, 0.5}) {
    HitDetector detector({kMass, mass});
    std::optional<Hit> hit;
    for (int ms = 0; ms < 2; ++ms) {
      auto state = at(ms, {0, 0, 0}, {1, 0, 0}, 0);
      state.body_count = 3;  // the third has no mass in the list
      for (std::size_t i : {1u, 2u}) {
        state.bodies[i].set_v({0, ms == 0 ? -2.0 : 1.0 + static_cast<double>(i), 0});
        state.bodies[i].jumps = static_cast<std::uint32_t>(ms);
      }
      hit = detector.look(state);
    }
    EXPECT_EQ(hit.has_value(), mass > 0.0);
    if (hit) {
      EXPECT_DOUBLE_EQ(hit->impulse, mass * 4.0);
    }
  }
}

TEST(HitDetector, DoesNotHearAServeOrASoftTouch) {
  HitDetector detector(kMasses);
  detector.look(at(0, {0, 0, 0}, {1, -2, 0}, 5));
  EXPECT_FALSE(detector.look(at(1, {0.5, 0.3, 0}, {-1, 0, 2}, 6)));     // put elsewhere
  detector.look(at(2, {0.5, 0.3, 0}, {0, 0, 0}, 7));                    // waits
  EXPECT_FALSE(detector.look(at(3, {0.5, 0.3, 0}, {2, 0, 1}, 8)));      // leaves
  EXPECT_FALSE(detector.look(at(4, {0.502, 0.3, 0}, {2, 0.1, 1}, 9)));  // 0.1 m/s
}

// The force of half a sine, whose impulse is 2 F T / pi.
TEST(HitDetector, AddsUpTheImpulseOfAnImpactAtAnyPhaseOfTheTicks) {
  const double F = 7.0, T = 4e-3;
  for (const double phase : {0.05, 0.3, 0.5, 0.9}) {
    HitDetector detector(kMasses);
    std::optional<Hit> hit;
    for (int ms = 0; ms < 12; ++ms) {
      scene::SceneState state = at(ms, {0, 0, 0}, {0, 0, 1}, 3);
      const double since = (ms - 3 + phase) * 1e-3;
      if (since >= 0.0 && since <= T) {
        state.impact.share = std::max(1e-6, since / T);
        state.impact.force = {0, 0, F * std::sin(std::numbers::pi * since / T)};
      }
      if (const auto found = detector.look(state)) {
        EXPECT_FALSE(hit);
        hit = found;
      }
    }
    ASSERT_TRUE(hit);
    EXPECT_EQ(hit->kind, HitKind::hand);
    // The trapezoidal rule on four steps of a half sine: a few per cent.
    EXPECT_NEAR(hit->impulse / (2.0 * F * T / std::numbers::pi), 1.0, 0.08) << phase;
    EXPECT_NEAR(hit->peak, F, 0.08 * F);
  }
}

TEST(HitDetector, TellsOfAnImpactOnceThoughTheBallsVelocityJumpsInIt) {
  HitDetector detector(kMasses);
  int heard = 0;
  for (int ms = 0; ms < 10; ++ms) {
    scene::SceneState state = at(ms, {0, 0, 0.001 * ms}, {0, 0, ms < 5 ? 1.0 : -1.0},
                                 ms < 3   ? 1u
                                 : ms < 6 ? 2u
                                          : 3u);
    if (ms >= 3 && ms < 6) {
      state.impact.share = 0.3 * (ms - 2);
      state.impact.force = {0, 0, 2};
    }
    if (detector.look(state)) ++heard;
  }
  EXPECT_EQ(heard, 1);
}

TEST(HitDetector, SaysNothingOfWhatHappenedWhileNothingWasSeen) {
  HitDetector detector(kMasses);
  detector.look(at(0, {0, 0, 0}, {0, -2, 0}, 1));
  EXPECT_FALSE(detector.look(at(500, {0, 0, 0}, {0, 2, 0}, 2)));
  // Nor of a state that comes twice or late.
  EXPECT_FALSE(detector.look(at(500, {0, 0, 0}, {0, -2, 0}, 3)));
  EXPECT_FALSE(detector.look(at(400, {0, 0, 0}, {0, -2, 0}, 4)));
}

}  // namespace
}  // namespace palpate::desktop
