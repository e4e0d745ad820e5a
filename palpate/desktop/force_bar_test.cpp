#include "palpate/desktop/force_bar.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace palpate::desktop {
namespace {

TEST(ForceBar, ShowsNothingBeforeTheFirstForce) {
  const ForceBar bar;
  EXPECT_EQ(bar.level(0.0), 0.0);
  EXPECT_FALSE(bar.shows(0.0));
}

TEST(ForceBar, HoldsAPeakAndLetsItFall) {
  ForceBar bar;
  bar.feel(1.0, 5.0);
  EXPECT_EQ(bar.level(1.0), 5.0);
  EXPECT_EQ(bar.level(1.0 + 0.99 * ForceBar::kHold_s), 5.0);
  EXPECT_NEAR(bar.level(1.0 + ForceBar::kHold_s + ForceBar::kFall_s), 5.0 / std::exp(1.0), 1e-12);
  EXPECT_FALSE(bar.shows(4.0));
}

TEST(ForceBar, IsNotPulledDownByASmallerForceButTakesAGreaterOneAtOnce) {
  ForceBar bar;
  bar.feel(1.0, 5.0);
  bar.feel(1.1, 2.0);
  EXPECT_EQ(bar.level(1.1), 5.0);
  bar.feel(1.2, 8.0);
  EXPECT_EQ(bar.level(1.2), 8.0);
  EXPECT_EQ(bar.last_peak(), 8.0);
}

TEST(ForceBar, FollowsAForceThatLasts) {
  ForceBar bar;
  for (int ms = 0; ms < 3000; ++ms) bar.feel(1e-3 * ms, 1.5);
  EXPECT_EQ(bar.level(3.0), 1.5);
}

TEST(ForceBar, TakesNoForceThatIsNoNumber) {
  ForceBar bar;
  bar.feel(1.0, std::numeric_limits<double>::quiet_NaN());
  EXPECT_EQ(bar.level(1.0), 0.0);
}

TEST(ForceBar, ShowsAForceThatLastsAsItIs) {
  ForceBar bar;
  bar.last(0.3);
  EXPECT_DOUBLE_EQ(bar.level(1.0), 0.3);
  bar.last(0.2);
  EXPECT_DOUBLE_EQ(bar.level(1.001), 0.2) << "no peak of it is held";
  EXPECT_DOUBLE_EQ(bar.last_peak(), 0.2);
  bar.feel(2.0, 4.0);  // a blow meanwhile
  EXPECT_DOUBLE_EQ(bar.level(2.1), 4.0);
  bar.last(0.0);
  EXPECT_LT(bar.level(10.0), 1e-6);
  EXPECT_DOUBLE_EQ(bar.last_peak(), 4.0);
}

}  // namespace
}  // namespace palpate::desktop
