#include "palpate/scene/setting_text.h"

#include <gtest/gtest.h>

namespace palpate::scene {
namespace {

SettingSchema schema() {
  return {{number_field("pad", "stiffness_n_m", 600.0, {1.0, 2000.0}, "Of the pad"),
           numbers_field("pad", "place_mm", {0.0, 1.0, 2.0}, {-10.0, 10.0}, "Where it lies", 1e-3),
           choice_field("pad", "colour", "red", {"red", "green"}, "Of the pad")}};
}

std::string refusal(const std::string& said) {
  SettingValues values(schema());
  const auto done = set_by_text(schema(), said, values);
  return done ? "taken" : done.error().message;
}

TEST(SettingText, NumbersListsAndWordsAreTakenToTheLastBit) {
  SettingValues values(schema());
  for (const auto* said :
       {"pad.stiffness_n_m=700.10000000000002", "pad.place_mm=+1,-2.5,1e-3", "pad.colour=green"}) {
    const auto done = set_by_text(schema(), said, values);
    ASSERT_TRUE(done) << done.error().message;
  }
  EXPECT_EQ(values.number("pad.stiffness_n_m"), 700.1);
  EXPECT_EQ(values.vector("pad.place_mm"), Vector3(1e-3, -2.5e-3, 1e-6));
  EXPECT_EQ(values.text("pad.colour"), "green");
}

TEST(SettingText, WhatIsNoSettingIsToldWithWhatWasMeant) {
  EXPECT_EQ(refusal("pad.stifness_n_m=3"),
            "pad.stifness_n_m: no such setting; did you mean pad.stiffness_n_m?");
  EXPECT_EQ(refusal("mass=3"),
            "mass: no such setting; there are pad.stiffness_n_m, pad.place_mm, pad.colour");
  EXPECT_EQ(refusal("pad.colour"), "pad.colour: NAME=VALUE is expected, such as pad.stiffness_n_m=...");
  EXPECT_EQ(refusal("pad.stiffness_n_m=soft"), "pad.stiffness_n_m: soft: a number is expected");
  EXPECT_EQ(refusal("pad.stiffness_n_m="), "pad.stiffness_n_m: : a number is expected");
  EXPECT_EQ(refusal("pad.place_mm=1,2"), "pad.place_mm: 1,2: 3 numbers are expected");
  EXPECT_EQ(refusal("pad.place_mm=1,2,3,"),
            "pad.place_mm: 1,2,3,: a list of numbers with commas is expected");
}

}  // namespace
}  // namespace palpate::scene
