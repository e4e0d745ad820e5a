#include "palpate/rig/internal/number_text.h"

#include <gtest/gtest.h>

#include <cstdlib>

#include "palpate/core/random.h"
#include "palpate/core/units.h"

namespace palpate::rig {
namespace {

TEST(NumberText, InTheFilesUnitItHasTheDigitsThatItWasReadWith) {
  EXPECT_EQ(number_text(209.55 / kMillimetresPerMetre, kMillimetresPerMetre), "209.55");
  EXPECT_EQ(number_list(Eigen::Vector3d(0.001, 0.0201, -0.3), kMillimetresPerMetre), "[1.0, 20.1, -300.0]");
}

TEST(NumberText, WhatWasMeasuredComesBackWithinALastPlaceAndWithoutAUnitExactly) {
  Random random(3, "number text");
  for (int i = 0; i < 10'000; ++i) {
    const double value = random.normal(1.0);
    EXPECT_EQ(std::strtod(number_text(value).c_str(), nullptr), value);
    const std::string text = number_text(value, kMillimetresPerMetre);
    const double written = std::strtod(text.c_str(), nullptr);
    // Shorter than the product only where that loses nothing.
    if (written != kMillimetresPerMetre * value) {
      EXPECT_EQ(written / kMillimetresPerMetre, value);
      EXPECT_EQ(written * (1.0 / kMillimetresPerMetre), value);
    }
    EXPECT_NEAR(written / kMillimetresPerMetre, value, 4.5e-16 * std::abs(value));
  }
  EXPECT_EQ(number_text(0.1 + 0.2), "0.30000000000000004");
}

}  // namespace
}  // namespace palpate::rig
