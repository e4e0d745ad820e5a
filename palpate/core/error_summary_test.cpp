#include "palpate/core/error_summary.h"

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

}  // namespace
}  // namespace palpate::inline core
