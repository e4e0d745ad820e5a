#include <gtest/gtest.h>

#include "palpate/headset/headset.h"

namespace palpate::headset {
namespace {

TEST(WithoutOpenXr, AHeadsetIsRefusedWithTheRemedy) {
  HeadsetSettings settings;
  settings.eyes = {Eye{}};
  EXPECT_FALSE(Headset::built_in());
  const auto opened = Headset::open(settings);
  ASSERT_FALSE(opened);
  EXPECT_NE(opened.error().message.find("libopenxr-dev"), std::string::npos) << opened.error().message;
  EXPECT_FALSE(Headset::look_for());
}

}  // namespace
}  // namespace palpate::headset
