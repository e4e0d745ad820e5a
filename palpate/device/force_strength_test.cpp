#include "palpate/device/force_strength.h"

#include <gtest/gtest.h>

#include <cmath>

namespace palpate::device {
namespace {

constexpr double kTick = 0.001;

ForceStrength full() {
  ForceStrength strength({});
  for (int i = 0; i < 1100; ++i) strength.tick(true, 0.0, kTick);
  EXPECT_EQ(strength.gain(), 1.0);
  return strength;
}

// Of good data missing for `gap_ms`, noticed tick by tick.
void miss(ForceStrength& strength, int gap_ms) {
  for (int ms = 5; ms < gap_ms; ++ms) strength.tick(false, 1e-3 * ms, kTick);
}

TEST(ForceStrength, TheFirstRampBeginsWithNothingAndTakesItsTime) {
  ForceStrength strength({});
  for (int i = 0; i < 10; ++i) strength.tick(false, 1.0, kTick);
  for (int i = 0; i <= 1000; ++i) {
    strength.tick(true, 0.0, kTick);
    ASSERT_NEAR(strength.gain(), 1e-3 * i, 1e-12);
  }
}

TEST(ForceStrength, TheRampIsWalkedInRealTimeHoweverLateTicksAre) {
  ForceStrength strength({});
  double since = 0.0;
  strength.tick(true, 0.0, kTick);
  for (int i = 0; since < 0.99; ++i) {
    const double elapsed = i % 3 == 0 ? 0.0045 : 0.0003;
    since += elapsed;
    strength.tick(true, 0.0, elapsed);
    ASSERT_NEAR(strength.gain(), since, 1e-9);
  }
}

TEST(ForceStrength, ForcesAreGoneWithin20MsOfTheLastGoodData) {
  ForceStrength strength = full();
  for (int ms = 5; ms <= 19; ++ms) strength.tick(false, 1e-3 * ms, kTick);
  EXPECT_EQ(strength.gain(), 0.0);
}

TEST(ForceStrength, ABriefOutageEndsWithin50MsAndALongOneAlongTheRamp) {
  for (int gap = 6; gap <= 200; ++gap) {
    ForceStrength strength = full();
    miss(strength, gap);
    const double faded = strength.gain();
    EXPECT_NEAR(faded, std::max(0.0, 1.0 - (gap - 5) / 15.0), 1e-9);
    strength.tick(true, 0.0, kTick);
    const bool brief = gap <= 55;  // it began 5 ms after the last good data
    EXPECT_EQ(strength.brief(), brief) << gap;
    EXPECT_NEAR(strength.outage_s(), 1e-3 * (gap - 5), 1e-9);
    EXPECT_EQ(strength.gain(), brief ? faded : 0.0) << gap;
    for (int ms = 1; ms < 50; ++ms) strength.tick(true, 0.0, kTick);
    EXPECT_NEAR(strength.gain(), brief ? 1.0 : 0.049, 1e-9) << gap;
  }
}

TEST(ForceStrength, ALateTickGoesOnFromWhatIsHeldOrFromNothing) {
  for (int gap = 5; gap <= 2000; gap += gap < 100 ? 1 : 50)
    for (const double held : {0.0, 0.4, 1.0}) {
      ForceStrength strength = full();
      strength.tick(true, 0.0, 1e-3 * gap, held);
      const bool brief = gap <= 55;
      ASSERT_EQ(strength.gain(), brief ? held : 0.0) << gap;
      for (int ms = 1; ms < 50; ++ms) strength.tick(true, 0.0, kTick);
      ASSERT_NEAR(strength.gain(), brief ? 1.0 : 0.049, 1e-9) << gap;
    }
}

TEST(ForceStrength, ALateTickThatSeesNothingGoodFadesByTheTimeThatHasPassed) {
  ForceStrength strength = full();
  strength.tick(false, 0.012, 0.012);
  EXPECT_NEAR(strength.gain(), 1.0 - 12.0 / 15.0, 1e-9);
  strength.tick(false, 0.042, 0.030);
  EXPECT_EQ(strength.gain(), 0.0);
  strength.tick(true, 0.0, kTick);
  EXPECT_TRUE(strength.brief());  // 43 ms since the last good data
  strength.tick(false, 0.060, 0.060);
  strength.tick(true, 0.0, kTick);
  EXPECT_FALSE(strength.brief());
}

TEST(ForceStrength, ABriefOutageWithinTheRampDoesNotShortenIt) {
  ForceStrength strength({});
  for (int i = 0; i <= 300; ++i) strength.tick(true, 0.0, kTick);
  miss(strength, 30);
  for (int i = 0; i <= 50; ++i) strength.tick(true, 0.0, kTick);
  EXPECT_NEAR(strength.gain(), 0.350, 1e-9);
}

TEST(ForceStrength, WhatBeginsAnewBeginsTheRamp) {
  ForceStrength strength = full();
  strength.restart();
  EXPECT_EQ(strength.gain(), 0.0);
  strength.tick(true, 0.0, kTick);
  EXPECT_EQ(strength.gain(), 0.0);
  strength.tick(true, 0.0, kTick);
  EXPECT_NEAR(strength.gain(), 0.001, 1e-12);
}

}  // namespace
}  // namespace palpate::device
