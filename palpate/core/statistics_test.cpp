#include "palpate/core/statistics.h"

#include <gtest/gtest.h>

#include <cmath>

namespace palpate::inline core {
namespace {

TEST(ErrorSummary, FiguresOfAKnownSet) {
  ErrorSummary summary;
  for (int i = 1; i <= 100; ++i) summary.add(i);
  EXPECT_NEAR(summary.rms(), std::sqrt(338350.0 / 100.0), 1e-12);
  EXPECT_EQ(summary.quantile(0.95), 95.0);
  EXPECT_EQ(summary.maximum(), 100.0);
  EXPECT_EQ(ErrorSummary().quantile(0.95), 0.0);
}

TEST(Quantile, IsLinearBetweenNeighbours) {
  EXPECT_DOUBLE_EQ(quantile({4, 1, 3, 2}, 0.5), 2.5);
  EXPECT_DOUBLE_EQ(quantile({4, 1, 3, 2}, 1.0), 4.0);
  EXPECT_DOUBLE_EQ(quantile({4, std::nan(""), 1, 3, 2}, 0.0), 1.0) << "what is no number is left out";
  EXPECT_TRUE(std::isnan(quantile({}, 0.5)));
}

TEST(Median, IsTheUpperOfTwoInTheMiddle) {
  EXPECT_EQ(median({5, 1, 3}), 3.0);
  EXPECT_EQ(median({4, 1, 3, 2}), 3.0);
  EXPECT_EQ(median({}), 0.0);
}

}  // namespace
}  // namespace palpate::inline core
