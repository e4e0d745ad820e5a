#include "palpate/rig/internal/number_text.h"

#include <gtest/gtest.h>

#include <cstdlib>

#include "palpate/core/random.h"
#include "palpate/core/units.h"

namespace palpate::rig {
namespace {

constexpr double kMm = 1.0 / kMillimetresPerMetre;

TEST(NumberText, InTheFilesUnitItHasTheDigitsThatItWasReadWith) {
  EXPECT_EQ(number_list(kMm * Eigen::Vector3d(1.0, 20.1, -300.0), kMillimetresPerMetre),
            "[1.0, 20.1, -300.0]");
  int off = 0;
  for (int k = -40'000; k < 40'000; ++k) {
    const double text = k / 100.0, read = kMm * text;
    ASSERT_EQ(std::strtod(number_text(read, kMillimetresPerMetre).c_str(), nullptr), text);
    off += kMillimetresPerMetre * read != text;
  }
  EXPECT_GT(off, 1000) << "times 1000 these are a last place off what was read";
  EXPECT_EQ(number_text(kMm * 209.55, kMillimetresPerMetre), "209.55");
  EXPECT_EQ(number_text(kMm * -31.67, kMillimetresPerMetre), "-31.67");
}

TEST(NumberText, ListsAndRowsHaveTheirNumbersInOrder) {
  EXPECT_EQ(number_list(Quaternion(0.5, -0.25, 0.125, 1.0)), "[0.5, -0.25, 0.125, 1.0]");
  const Eigen::Matrix<double, 2, 3> m = (Eigen::Matrix<double, 2, 3>() << 1, 2, 3, 4, 5, 6).finished();
  EXPECT_EQ(number_rows(m, 10.0), "[\n  [10.0, 20.0, 30.0],\n  [40.0, 50.0, 60.0]\n]");
}

// What stands in a file is read as a rig's numbers are, written and read again: a session is executed again with what its
// recording holds.
TEST(NumberText, WhatWasReadComesBackToTheBit) {
  Random random(4, "number text/read");
  for (int i = 0; i < 100'000; ++i) {
    const double read = kMm * random.normal(300.0);
    ASSERT_EQ(kMm * std::strtod(number_text(read, kMillimetresPerMetre).c_str(), nullptr), read);
  }
}

TEST(NumberText, WhatWasMeasuredComesBackWithinALastPlaceAndWithoutAUnitExactly) {
  Random random(3, "number text");
  int lost = 0;
  for (int i = 0; i < 10'000; ++i) {
    const double value = random.normal(1.0);
    EXPECT_EQ(std::strtod(number_text(value).c_str(), nullptr), value);
    const double written = std::strtod(number_text(value, kMillimetresPerMetre).c_str(), nullptr);
    // Other than the product only where that reads back the better.
    if (written != kMillimetresPerMetre * value) {
      EXPECT_EQ(kMm * written, value);
    }
    EXPECT_NEAR(kMm * written, value, 4.5e-16 * std::abs(value));
    lost += kMm * written != value;
  }
  // Of what no text's number leads to, where the file's numbers lie further apart than those in metres.
  EXPECT_LT(lost, 350);
  EXPECT_EQ(number_text(0.1 + 0.2), "0.30000000000000004");
}

}  // namespace
}  // namespace palpate::rig
