#include "palpate/core/nearest.h"

#include <gtest/gtest.h>

namespace palpate::inline core {
namespace {

TEST(Nearest, DistancesAreThoseOfTextbooks) {
  EXPECT_EQ(edit_distance("kitten", "sitting"), 3u);
  EXPECT_EQ(edit_distance("saturday", "sunday"), 3u);
  EXPECT_EQ(edit_distance("", "demo"), 4u);
  EXPECT_EQ(edit_distance("demo", "demo"), 0u);
}

TEST(Nearest, IsTheWordWithTheFewestLettersAmiss) {
  const std::vector<std::string> known = {"seed", "seconds", "stereo", "headless"};
  EXPECT_EQ(nearest("stero", known), "stereo");
  EXPECT_EQ(nearest("seeds", known), "seed");
  EXPECT_EQ(nearest("sceonds", known), "seconds");
  EXPECT_EQ(nearest("headles", known), "headless");
}

TEST(Nearest, IsNoneWhereNothingIsLikeTheWord) {
  const std::vector<std::string> known = {"rig", "up", "seconds"};
  EXPECT_EQ(nearest("monitor", known), "");
  EXPECT_EQ(nearest("fly", std::vector<std::string>{"play"}), "") << "two letters amiss of three";
  EXPECT_EQ(nearest("", known), "");
  EXPECT_EQ(nearest("rig", std::vector<std::string>{}), "");
}

}  // namespace
}  // namespace palpate::inline core
