#include "palpate/server/physics/delay_line.h"

#include <gtest/gtest.h>

#include <vector>

namespace palpate::server::physics {
namespace {

Instant<PhysicsClock> at_ms(int ms) { return Instant<PhysicsClock>{std::chrono::milliseconds(1000 + ms)}; }

haptics::HapticInput input_at(int ms) {
  haptics::HapticInput input;
  input.time = at_ms(ms);
  input.continuous = Vector3(ms, 0, 0);
  input.impact.number = static_cast<std::uint64_t>(ms / 100);
  input.impact.start = at_ms(ms / 100 * 100);
  input.earlier[0].start = at_ms(ms / 100 * 100 - 100);
  return input;
}

TEST(DelayLine, WithoutDelayEverythingPassesAsItIs) {
  DelayLine line;
  const auto out = line.push(input_at(7), at_ms(7));
  ASSERT_TRUE(out);
  EXPECT_EQ(out->time, at_ms(7));
}

TEST(DelayLine, EveryInputComesOutLaterByTheDelayAndSaysSo) {
  DelayLine line;
  line.set(std::chrono::milliseconds(40));
  for (int ms = 0; ms < 400; ++ms) {
    const auto out = line.push(input_at(ms), at_ms(ms));
    ASSERT_EQ(out.has_value(), ms >= 40) << ms;
    if (!out) continue;
    EXPECT_EQ(out->continuous.x(), ms - 40);
    EXPECT_EQ(out->time, at_ms(ms)) << "what comes out counts as of now: physics has not stood still";
    EXPECT_EQ(out->impact.start, at_ms((ms - 40) / 100 * 100 + 40)) << "a blow is played whole, later";
    EXPECT_EQ(out->earlier[0].start, at_ms((ms - 40) / 100 * 100 - 60));
  }
}

TEST(DelayLine, AfterAPauseOnlyTheNewestDueComesOutAndAFullLineGoesOn) {
  DelayLine line;
  line.set(DelayLine::kMost);
  for (int ms = 0; ms < 100; ++ms) EXPECT_FALSE(line.push(input_at(ms), at_ms(ms)));
  const auto out = line.push(input_at(1000), at_ms(1000));
  ASSERT_TRUE(out);
  EXPECT_EQ(out->continuous.x(), 99);
  // Far faster than any physics loop: places run out, the oldest go.
  for (int i = 0; i < 5000; ++i) line.push(input_at(1001), at_ms(1001));
  const auto late = line.push(input_at(1300), at_ms(1300));
  ASSERT_TRUE(late);
  EXPECT_EQ(late->continuous.x(), 1001);
}

}  // namespace
}  // namespace palpate::server::physics
