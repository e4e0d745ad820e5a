#include "palpate/haptics/motor_heat.h"

#include <gtest/gtest.h>

#include "palpate/core/random.h"

namespace palpate::haptics {
namespace {

TEST(MotorHeat, CoolMotorsGiveThePeakAndWarmOnesTheContinuousForce) {
  MotorHeat heat(ForceLimits{});
  EXPECT_EQ(heat.allowed_n(), 8.5);
  for (int i = 0; i < 20000; ++i) heat.held(1.4, 0.001);  // for 20 time constants
  EXPECT_NEAR(heat.heat(), 1.0, 1e-6);
  EXPECT_NEAR(heat.allowed_n(), 1.4, 1e-4);
  EXPECT_TRUE(heat.warm());
}

TEST(MotorHeat, ItRisesAndFallsAsAWindingDoes) {
  MotorHeat heat(ForceLimits{});
  for (int i = 0; i < 300; ++i) heat.held(1.4, 0.001);
  EXPECT_NEAR(heat.heat(), 1.0 - std::exp(-0.3), 1e-12);
  heat.held(0.0, 0.5);
  EXPECT_NEAR(heat.heat(), (1.0 - std::exp(-0.3)) * std::exp(-0.5), 1e-12);
}

TEST(MotorHeat, WhoeverTakesAllThatIsAllowedNeverPassesTheContinuousForce) {
  Random random(1, "heat/greedy");
  for (const double tau : {0.5, 1.0, 30.0}) {
    ForceLimits limits;
    limits.continuous_s = tau;
    MotorHeat heat(limits);
    double worst = 0.0, energy = 0.0, time = 0.0;
    for (int i = 0; i < 200000; ++i) {
      const double tick = random.chance(0.01) ? 0.004 : 0.001, f = heat.allowed_n();
      heat.held(f, tick);
      worst = std::max(worst, heat.heat());
      energy += f * f * tick;
      time += tick;
    }
    EXPECT_LE(worst, 1.0 + 1e-12);
    // The first push comes on top of the long run: one time constant's worth of the continuous force. Uneven
    // ticks weigh by 1 - exp(-t/tau), not by t: up to 4 ms / 2 tau.
    EXPECT_LE(energy, 1.4 * 1.4 * (time + tau) * (1.0 + 0.002 / tau));
    EXPECT_GT(energy, 0.95 * 1.4 * 1.4 * time);
  }
}

}  // namespace
}  // namespace palpate::haptics
