#include "palpate/formats/tables.h"

#include <gtest/gtest.h>

#include <cmath>

#include "palpate/core/file.h"
#include "tests/from_text.h"

namespace palpate::formats {
namespace {

using tests::from_text;

const char* const kArm =
    "joint_1_deg;joint_2_deg;joint_3_deg;x_mm;y_mm;z_mm\n"
    "1,5;-20;3e1;100;-200,25;300\n\n# a remark; with, signs\n2,5;-20;30;;;\n3,5;-20;30;1;2;3\n";

TEST(Tables, AnArmsSamplesAreReadWhateverSeparatesThem) {
  const auto file = from_text(kArm, read_arm_samples);
  ASSERT_TRUE(file.has_value()) << file.error().message;
  ASSERT_EQ(file->observations.size(), 2u);
  EXPECT_EQ(file->left_out, 1u) << "the tracker saw nothing in the second row";
  const auto& first = file->observations[0];
  EXPECT_DOUBLE_EQ(first.joints[0], 1.5 * std::acos(-1.0) / 180.0);
  EXPECT_DOUBLE_EQ(first.joints[2], 30.0 * std::acos(-1.0) / 180.0);
  EXPECT_LT((first.tip.value().m - Vector3(0.1, -0.20025, 0.3)).norm(), 1e-15);
  EXPECT_EQ(first.line, 2);
  EXPECT_EQ(file->observations[1].line, 6);
  const auto tabs =
      from_text("joint_1\tx_t\ty_t\tz_t\tx_dif\ty_dif\tz_dif\n1\t2\t3\t4\t0\t0\t1\n", read_arm_samples);
  ASSERT_TRUE(tabs.has_value()) << tabs.error().message;
  EXPECT_DOUBLE_EQ(tabs->observations[0].tip.value().m.z(), 0.005);
}

TEST(Tables, ATabAtTheEndOfARowBeginsAnEmptyCell) {
  const auto file = from_text("joint_1_deg\tx_mm\ty_mm\tz_mm\n1\t2\t3\t4\n2\t\t\t\n", read_arm_samples);
  ASSERT_TRUE(file.has_value()) << file.error().message;
  EXPECT_EQ(file->left_out, 1u);
}

TEST(Tables, AnArmsSamplesThatCannotBeReadAreNamedByTheirLine) {
  const auto complaint = [](const std::string& text) {
    const auto file = from_text(text, read_arm_samples);
    return file ? std::string() : file.error().message;
  };
  EXPECT_NE(complaint(std::string(kArm) + "x;1;2;3;4;5\n").find("table.csv:7: joint_1_deg is 'x'"),
            std::string::npos)
      << complaint(std::string(kArm) + "x;1;2;3;4;5\n");
  EXPECT_NE(complaint(std::string(kArm) + "1;1;2;3;4;\n").find("z_mm is ''"), std::string::npos);
  EXPECT_NE(complaint("joint_1_deg;x_mm;y_mm;z_mm\n1;;;\n").find("seen in none of 1 row"), std::string::npos);
}

TEST(Tables, OwnColumnsAreAllReadWhateverSeparatesThem) {
  const std::string poses =
      "time_s;x_mm;y_mm;z_mm;qw;qx;qy;qz;segment\n0,5;1;2;3;1;0;0;0;a\n1,5;1;2;3;1;0;0;0;b\n";
  const auto table = from_text(poses, [](const auto& path) {
    return read_poses(path, {.transform = {}, .segment_column = "segment"});
  });
  ASSERT_TRUE(table.has_value()) << table.error().message;
  EXPECT_EQ(table->file.segments, (std::vector<std::string>{"a", "b"}));
  EXPECT_EQ(table->file.poses[1].time_s, 1.5);
  EXPECT_EQ(table->file.hash, content_hash(poses));
  const auto points = from_text("label\tx_mm\ty_mm\tz_mm\tweight\nP\t1\t2\t3\t0.5\n",
                                [](const auto& path) { return read_points(path); });
  ASSERT_TRUE(points.has_value()) << points.error().message;
  EXPECT_EQ(points->file.weights.at(0), 0.5);
  EXPECT_EQ(points->file.labels.at(0), "P");
  const auto quoted = from_text("label;x_mm;y_mm;z_mm\n\"left, upper\";1;2;3\n",
                                [](const auto& path) { return read_points(path); });
  ASSERT_TRUE(quoted.has_value()) << quoted.error().message;
  EXPECT_EQ(quoted->file.labels.at(0), "left, upper");
}

}  // namespace
}  // namespace palpate::formats
