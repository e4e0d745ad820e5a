#include "palpate/device/spare_pixels.h"

#include <gtest/gtest.h>

namespace palpate::device {
namespace {

TEST(SparePixels, LendsWhatItKeepsAndKeepsFew) {
  SparePixels spare;
  EXPECT_TRUE(spare.take().empty());
  spare.keep({});
  EXPECT_EQ(spare.take().capacity(), 0u) << "there was nothing to keep";
  std::vector<std::uint8_t> pixels(100, 7);
  const std::uint8_t* memory = pixels.data();
  spare.keep(std::move(pixels));
  EXPECT_EQ(spare.take().data(), memory);
  for (int i = 0; i < 10; ++i) spare.keep(std::vector<std::uint8_t>(100));
  int lent = 0;
  while (spare.take().capacity() > 0) ++lent;
  EXPECT_EQ(lent, 3) << "a camera that stands still holds no more";
}

}  // namespace
}  // namespace palpate::device
