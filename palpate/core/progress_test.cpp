#include "palpate/core/progress.h"

#include <gtest/gtest.h>

namespace palpate::inline core {
namespace {

TEST(Progress, SharesFollowTheExpectedTimes) {
  Progress progress({{"a", 1.0}, {"b", 3.0}});
  progress.begin(0);
  progress.update(0.5);
  EXPECT_DOUBLE_EQ(progress.share(), 0.125);
  progress.begin(1);
  EXPECT_DOUBLE_EQ(progress.share(), 0.25);
  progress.update(2.0);
  EXPECT_DOUBLE_EQ(progress.share(), 1.0);
}

TEST(Progress, TimeLeftReadsLikeATime) {
  EXPECT_EQ(time_left_text(11.2), "12 s left");
  EXPECT_EQ(time_left_text(65.0), "1:05 left");
  EXPECT_EQ(time_left_text(-3.0), "0 s left");
}

}  // namespace
}  // namespace palpate::inline core
