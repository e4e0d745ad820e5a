#include "palpate/haptics/passivity.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

namespace palpate::haptics {
namespace {

constexpr double kMs = 0.001;

// A stylus of 75 g without a hand, thrown at 0.3 m/s at a sampled wall of stiffness k, a tick late;
// integrated in steps of 10 us. The kinetic energy after each visit, over that before the first.
std::vector<double> visits(double k, double device_damping, double most_damping) {
  const double mass = 0.075, h = 1e-5;
  double x = -0.01, v = 0.3, force = 0.0, x_before = x, v_tick = 0.0;
  PassivityObserver passivity(most_damping);
  std::vector<double> energies;
  bool inside = false;
  double requested = 0.0;
  for (int i = 0; i < 30000 && energies.size() < 5; ++i) {
    v_tick = (x - x_before) / kMs;
    const bool touching = requested != 0.0 || force != 0.0;
    passivity.moved({force, 0.0, 0.0}, {x - x_before, 0.0, 0.0}, touching);
    x_before = x;
    force = requested + (touching ? passivity.damping({v_tick, 0.0, 0.0}, kMs).x() : 0.0);
    requested = x > 0.0 ? -k * x : 0.0;  // answers to this tick's place, in the next tick
    if (requested != 0.0) inside = true;
    if (inside && x < 0.0 && v < 0.0 && force == 0.0 && requested == 0.0) {
      energies.push_back(v * v / 0.09);
      inside = false;
    }
    if (x < -0.01 && v < 0.0) x = -0.01, v = -v, x_before = x;  // thrown back as fast as it came
    for (int s = 0; s < 100; ++s) {
      v += h / mass * (force - device_damping * v);
      x += h * v;
    }
  }
  return energies;
}

TEST(Passivity, ASampledWallAloneGivesEnergyAndWithTheObserverItDoesNot) {
  // Colgate: passive where b > K T / 2; a tick of delay asks for three times that, 1.5 N s/m. The stylus has
  // 0.02. The stylus has 0.02.
  const auto bare = visits(1000.0, 0.02, 0.0);
  ASSERT_GE(bare.size(), 2u);
  EXPECT_GT(bare[0], 1.2);
  EXPECT_GT(bare[1], 1.2 * bare[0]);
  const auto watched = visits(1000.0, 0.02, 5.0);
  ASSERT_GE(watched.size(), 2u);
  // What the observer lets pass in each contact is its allowance of 0.1 mJ: 3 % of the first 3.4 mJ.
  double before = 1.0;
  for (const double energy : watched) {
    EXPECT_LT(energy, before + 0.031);
    before = energy;
  }
}

TEST(Passivity, ASpringThatGivesBackWhatItTookIsNotDamped) {
  PassivityObserver passivity(5.0);
  double x_before = 0.0;
  for (int i = 0; i <= 400; ++i) {
    // Into the wall and out again; the held force is that of the middle of the way.
    const double x = 0.002 * (1.0 - std::cos(2.0 * 3.141592653589793 * i / 400.0));
    passivity.moved({-400.0 * 0.5 * (x + x_before), 0.0, 0.0}, {x - x_before, 0.0, 0.0}, true);
    EXPECT_EQ(passivity.damping({0.05, 0.0, 0.0}, kMs).norm(), 0.0);
    x_before = x;
  }
  EXPECT_NEAR(passivity.energy(), 0.0, 1e-12);
}

TEST(Passivity, DampingOpposesTheMotionIsBoundedAndTakesTheExcessAway) {
  PassivityObserver passivity(2.0);
  passivity.moved({1.0, 0.0, 0.0}, {0.001, 0.0, 0.0}, true);  // 1 mJ given out
  const Vector3 v(0.3, 0.4, 0.0);
  const Vector3 f = passivity.damping(v, kMs);
  EXPECT_EQ(passivity.injected(), 2.0);
  EXPECT_NEAR((f + 2.0 * v).norm(), 0.0, 1e-12);
  passivity.moved({1.0, 0.0, 0.0}, {0.001, 0.0, 0.0}, true);
  const double before = passivity.energy();
  passivity.moved(f, kMs * v, true);
  EXPECT_NEAR(passivity.energy() - before, 2.0 * 0.25 * kMs, 1e-12);
  EXPECT_EQ(passivity.damping(Vector3::Zero(), kMs).norm(), 0.0);
  EXPECT_EQ(passivity.damping({std::nan(""), 0.0, 0.0}, kMs).norm(), 0.0);
}

TEST(Passivity, EachContactStandsForItself) {
  PassivityObserver passivity(2.0);
  passivity.moved({1.0, 0.0, 0.0}, {-0.01, 0.0, 0.0}, true);
  EXPECT_NEAR(passivity.energy(), 0.01, 1e-15);
  passivity.moved({0.0, 0.0, 0.0}, {0.01, 0.0, 0.0}, false);
  EXPECT_EQ(passivity.energy(), 0.0);
}

}  // namespace
}  // namespace palpate::haptics
