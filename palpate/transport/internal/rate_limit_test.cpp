#include "palpate/transport/internal/rate_limit.h"

#include <gtest/gtest.h>

namespace palpate::transport {
namespace {

TEST(RateLimit, GivesEachConnectionItsShareOfEachTenthOfASecond) {
  RateLimit limit(50);
  const auto begin = Instant<PhysicsClock>::from_seconds(7.0);
  for (int i = 0; i < 5; ++i) EXPECT_TRUE(limit.admits("a", begin + std::chrono::milliseconds(i)));
  EXPECT_FALSE(limit.admits("a", begin + std::chrono::milliseconds(99)));
  EXPECT_TRUE(limit.admits("b", begin + std::chrono::milliseconds(99)));
  EXPECT_TRUE(limit.admits("a", begin + std::chrono::milliseconds(100)));
}

}  // namespace
}  // namespace palpate::transport
