#include "palpate/device/point_file.h"

#include <gtest/gtest.h>

namespace palpate::device {
namespace {

TEST(PointFile, LabelsAreKnownByTheirColumnHoweverItIsWritten) {
  for (const char* name : {"label", "Label", "NAME", "Landmark"}) {
    const auto file = parse_points(std::string(name) + ",x_mm,y_mm,z_mm\nA,1,2,3\nB,4,5,6\n", "points.csv");
    ASSERT_TRUE(file) << file.error().message;
    EXPECT_EQ(file->labels, (std::vector<std::string>{"A", "B"})) << name;
  }
  EXPECT_TRUE(parse_points("x_mm,y_mm,z_mm,note\n1,2,3,A\n", "points.csv")->labels.empty());
}

TEST(PointFile, WithoutAHeaderItIsToldWhatWritesOne) {
  const auto file = parse_points("1,2,3\n4,5,6\n", "points.csv");
  ASSERT_FALSE(file);
  EXPECT_NE(file.error().message.find("has no header line; x_mm,y_mm,z_mm are expected"), std::string::npos);
  EXPECT_NE(file.error().message.find("palpate convert --unit mm"), std::string::npos);
}

}  // namespace
}  // namespace palpate::device
