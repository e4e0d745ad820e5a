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
  // Times 1000 these are a last place off what was read.
  const double read = 3.97 / kMillimetresPerMetre;
  ASSERT_NE(kMillimetresPerMetre * read, 3.97);
  EXPECT_EQ(number_text(read, kMillimetresPerMetre), "3.97");
  EXPECT_EQ(number_text(-31.67 / kMillimetresPerMetre, kMillimetresPerMetre), "-31.67");
}

TEST(NumberText, ListsAndRowsHaveTheirNumbersInOrder) {
  EXPECT_EQ(number_list(Quaternion(0.5, -0.25, 0.125, 1.0)), "[0.5, -0.25, 0.125, 1.0]");
  const Eigen::Matrix<double, 2, 3> m = (Eigen::Matrix<double, 2, 3>() << 1, 2, 3, 4, 5, 6).finished();
  EXPECT_EQ(number_rows(m, 10.0), "[\n  [10.0, 20.0, 30.0],\n  [40.0, 50.0, 60.0]\n]");
}

// What stands in a file is read, written and read again: a session is executed again with what its recording holds.
TEST(NumberText, WhatWasReadComesBackToTheBit) {
  Random random(4, "number text/read");
  for (int i = 0; i < 10'000; ++i) {
    const double read = random.normal(300.0) / kMillimetresPerMetre;
    EXPECT_EQ(std::strtod(number_text(read, kMillimetresPerMetre).c_str(), nullptr) / kMillimetresPerMetre,
              read);
  }
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
