#include "applications/palpation/settings.h"

#include <gtest/gtest.h>

#include "applications/palpation/specification.h"

namespace palpate::applications::palpation {
namespace {

TEST(PalpationSettings, AQuickDemosSearchIsShorterThanItWhereNobodySaidHowLong) {
  scene::SettingValues values(setting_schema());
  shorten_for_a_quick_demo(values);
  EXPECT_LT(values.number("palpation.trial_s"), specification().quick_demo_s - 1.0);
  values.set("palpation.trial_s", 40.0);
  shorten_for_a_quick_demo(values);
  EXPECT_EQ(values.number("palpation.trial_s"), 40.0);
}

}  // namespace
}  // namespace palpate::applications::palpation
