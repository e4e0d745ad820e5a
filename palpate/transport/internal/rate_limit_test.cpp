#include "palpate/transport/internal/rate_limit.h"

#include <gtest/gtest.h>

namespace palpate::transport {
namespace {

using Share = RateLimit::Share;
const auto kBegin = Instant<PhysicsClock>::from_seconds(7.0);

TEST(RateLimit, GivesEachConnectionItsShareOfEachTenthOfASecond) {
  RateLimit limit(50, 100);
  for (int i = 0; i < 5; ++i)
    EXPECT_EQ(limit.count("a", 10, kBegin + std::chrono::milliseconds(i)), Share::within);
  EXPECT_EQ(limit.count("a", 10, kBegin + std::chrono::milliseconds(99)), Share::beyond);
  EXPECT_EQ(limit.count("b", 10, kBegin + std::chrono::milliseconds(99)), Share::within);
  EXPECT_EQ(limit.count("a", 10, kBegin + std::chrono::milliseconds(100)), Share::within);
}

TEST(RateLimit, SaysWhichConnectionFillsTheMemory) {
  for (std::size_t bytes : {0u, 13u, 1000u, 4000u}) {
    RateLimit limit(1000, 2000);
    std::size_t sent = 0;
    while (sent < 2 * RateLimit::kFloodBytes && limit.count("a", bytes, kBegin) != Share::flood)
      sent += bytes + RateLimit::kBytesPerMessage;
    EXPECT_LE(sent, RateLimit::kFloodBytes);
    EXPECT_GT(sent, RateLimit::kFloodBytes - bytes - 2 * RateLimit::kBytesPerMessage);
    EXPECT_EQ(limit.count("a", bytes, kBegin), Share::beyond);
    EXPECT_EQ(limit.count("b", bytes, kBegin), Share::within);
    EXPECT_EQ(limit.count("a", bytes, kBegin + std::chrono::milliseconds(100)), Share::within);
  }
}

// Two seconds of a graphics server's messages, 300 a second, that come at once after a stall.
TEST(RateLimit, WhoWasHeldUpIsNoFlood) {
  RateLimit limit(20'000, 40'000);
  for (int i = 0; i < 600; ++i) EXPECT_EQ(limit.count("a", 80, kBegin), Share::within);
}

TEST(RateLimit, LongMessagesCountForMore) {
  RateLimit limit(1000, 2000);
  const auto within = [&](const std::string& peer, std::size_t bytes) {
    int count = 0;
    while (limit.count(peer, bytes, kBegin) == Share::within) ++count;
    return count;
  };
  EXPECT_EQ(within("short", 60), 100);
  EXPECT_EQ(within("long", 3000), 100 / 31);
}

// As quickly as answers come, over the quickest wire.
TEST(RateLimit, WhoAsksAgainWhenItIsAnsweredIsNoFlood) {
  RateLimit limit(20'000, 40'000);
  for (int i = 0; i < 100'000; ++i)
    EXPECT_EQ(limit.count("a", 60, kBegin + std::chrono::microseconds(50 * i)), Share::within);
}

TEST(RateLimit, ManyHaveTheirPartEach) {
  RateLimit limit(20'000, 40'000);
  const auto within = [&](Instant<PhysicsClock> now) {
    int count = 0;
    for (int i = 0; i < 1000; ++i)
      for (int peer = 0; peer < 40; ++peer)
        count += limit.count(std::to_string(peer), 13, now) == Share::within ? 1 : 0;
    return count;
  };
  EXPECT_LE(within(kBegin), 4000 + 40);
  EXPECT_EQ(within(kBegin + std::chrono::milliseconds(100)), 4000);
  EXPECT_EQ(limit.count("alone", 13, kBegin + std::chrono::milliseconds(300)), Share::within);
}

}  // namespace
}  // namespace palpate::transport
