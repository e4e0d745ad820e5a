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

}  // namespace
}  // namespace palpate::desktop
