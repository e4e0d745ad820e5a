#include "palpate/time/delay_line.h"

#include <gtest/gtest.h>

namespace palpate::inline time {
namespace {

Instant<PhysicsClock> at_ms(int ms) { return Instant<PhysicsClock>{std::chrono::milliseconds(1000 + ms)}; }

TEST(DelayLine, WithoutDelayEverythingPassesAsItIs) {
  DelayLine<int> line;
  EXPECT_EQ(line.push(7, at_ms(7)), 7);
}

TEST(DelayLine, EveryValueComesOutLaterByTheDelay) {
  DelayLine<int> line;
  line.set(std::chrono::milliseconds(40));
  for (int ms = 0; ms < 400; ++ms) {
    const auto out = line.push(ms, at_ms(ms));
    ASSERT_EQ(out.has_value(), ms >= 40) << ms;
    if (out) {
      EXPECT_EQ(*out, ms - 40);
    }
  }
}

TEST(DelayLine, AfterAPauseOnlyTheNewestDueComesOutAndAFullLineGoesOn) {
  DelayLine<int> line;
  line.set(DelayLine<int>::kMost);
  for (int ms = 0; ms < 100; ++ms) EXPECT_FALSE(line.push(ms, at_ms(ms)));
  const auto out = line.push(1000, at_ms(1000));
  ASSERT_TRUE(out);
  EXPECT_EQ(*out, 99);
  // Far faster than any physics loop: places run out, the oldest go.
  for (int i = 0; i < 5000; ++i) line.push(1001, at_ms(1001));
  const auto late = line.push(1300, at_ms(1300));
  ASSERT_TRUE(late);
  EXPECT_EQ(*late, 1001);
}

}  // namespace
}  // namespace palpate::inline time
