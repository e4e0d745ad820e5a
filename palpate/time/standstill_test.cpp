#include "palpate/time/standstill.h"

#include <gtest/gtest.h>

namespace palpate::inline time {
namespace {

Instant<PhysicsClock> moment_ms(int ms) { return Instant<PhysicsClock>{std::chrono::milliseconds(ms)}; }

TEST(Standstill, IsToldOnceACountHasNotMovedForSoLongAndEndsWithIt) {
  Standstill<PhysicsClock> standstill(std::chrono::milliseconds(20));
  for (int ms = 0; ms < 100; ++ms) EXPECT_FALSE(standstill.look(0, moment_ms(ms))) << "it has not begun";
  for (int ms = 100; ms < 200; ++ms)
    EXPECT_FALSE(standstill.look(static_cast<std::uint64_t>(ms), moment_ms(ms)));
  for (int ms = 200; ms < 219; ++ms) EXPECT_FALSE(standstill.look(199, moment_ms(ms))) << ms;
  for (int ms = 219; ms < 300; ++ms) EXPECT_TRUE(standstill.look(199, moment_ms(ms))) << ms;
  EXPECT_FALSE(standstill.look(200, moment_ms(300)));
  EXPECT_FALSE(standstill.look(200, moment_ms(319)));
  EXPECT_TRUE(standstill.look(200, moment_ms(320)));
}

}  // namespace
}  // namespace palpate::inline time
