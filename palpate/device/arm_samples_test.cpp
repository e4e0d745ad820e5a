#include "palpate/device/arm_samples.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <numbers>

#include "palpate/device/point_file.h"
#include "tests/from_text.h"

namespace palpate::device {
namespace {

namespace fs = std::filesystem;

using tests::from_text;

TEST(ArmSamples, MarkerPosesGimbalAndCovarianceAreRead) {
  const auto file = from_text(
      "time_s,joint_1_deg,joint_2_deg,joint_3_deg,gimbal_1_deg,gimbal_2_deg,gimbal_3_deg,marker_x_mm,marker_"
      "y_mm,"
      "marker_z_mm,marker_qw,marker_qx,marker_qy,marker_qz,cov_xx_mm2,cov_xy_mm2,cov_xz_mm2,cov_yy_mm2,cov_"
      "yz_mm2,"
      "cov_zz_mm2\n1.5,90,0,-180,10,20,30,1,2,3,0,1,0,0,4,0.1,0,5,0,6\n",
      read_arm_samples);
  ASSERT_TRUE(file.has_value()) << file.error().message;
  const auto& sample = file->observations.at(0);
  EXPECT_DOUBLE_EQ(sample.joints[2], -std::numbers::pi);
  EXPECT_DOUBLE_EQ(sample.gimbal.value()[2], std::numbers::pi / 6);
  EXPECT_DOUBLE_EQ(sample.time_s.value(), 1.5);
  EXPECT_DOUBLE_EQ(sample.marker.value().translation.y(), 0.002);
  EXPECT_DOUBLE_EQ(sample.marker.value().rotation.x(), 1.0);
  EXPECT_DOUBLE_EQ(sample.covariance.value()(1, 0), 1e-7);
  EXPECT_DOUBLE_EQ(sample.covariance.value()(2, 2), 6e-6);
  EXPECT_FALSE(sample.tip.has_value());
}

TEST(ArmSamples, MeasuredTipsAndRadiansAreRead) {
  const auto file = from_text("joint_1_rad,joint_2_rad,x_mm,y_mm,z_mm\n0.5,-1,1,2,3\n", read_arm_samples);
  ASSERT_TRUE(file.has_value()) << file.error().message;
  EXPECT_DOUBLE_EQ(file->observations[0].joints[1], -1.0);
  EXPECT_DOUBLE_EQ(file->observations[0].tip.value().m.z(), 0.003);
}

TEST(ArmSamples, APlaceThatTheArmStatesStandsInForItsJoints) {
  const auto file =
      from_text("arm_x_mm,arm_y_mm,arm_z_mm,x_mm,y_mm,z_mm\n10,-20,30,1,2,3\n", read_arm_samples);
  ASSERT_TRUE(file.has_value()) << file.error().message;
  EXPECT_TRUE(file->places);
  EXPECT_LT((file->observations[0].joints - Vector3(0.01, -0.02, 0.03)).norm(), 1e-17);
  EXPECT_EQ(file->observations[0].tip->m, Vector3(0.001, 0.002, 0.003));
  EXPECT_EQ(from_text("arm_x_m,arm_y_m,arm_z_m,x_m,y_m,z_m\n1,2,3,1,2,3\n", read_arm_samples)
                ->observations[0]
                .joints[2],
            3.0);
  EXPECT_FALSE(from_text("arm_x_mm,arm_y_mm,x_mm,y_mm,z_mm\n10,-20,1,2,3\n", read_arm_samples));
  EXPECT_FALSE(from_text("arm_x_m,arm_y_m,arm_z_m,x_m,y_m,z_m\n1e9,2,3,1,2,3\n", read_arm_samples));
  EXPECT_FALSE(
      from_text("joint_1_deg,joint_2_deg,joint_3_deg,x_m,y_m,z_m\n1,2,3,1,2,3\n", read_arm_samples)->places);
}

TEST(ArmSamples, TargetAndDifferenceMakeTheMeasuredPlace) {
  const auto file = read_arm_samples(fs::path(PALPATE_DATA_DIR) /
                                     "ur5_laser_tracker/3D_UR5_uncalibrated_random_cleaned.csv");
  ASSERT_TRUE(file.has_value()) << file.error().message;
  ASSERT_EQ(file->observations.size(), 20u);
  const auto& first = file->observations[0];
  ASSERT_EQ(first.joints.size(), 6);
  EXPECT_NEAR(first.tip.value().m.x(), -0.4954801493 - 0.0023820497, 1e-12);
  EXPECT_NEAR(first.joints[0], 17.272893800633657 * std::numbers::pi / 180.0, 1e-15);
}

TEST(ArmSamples, BadFilesAreRefused) {
  const auto complaint = [](const std::string& text) {
    const auto file = from_text(text, read_arm_samples);
    return file ? std::string("none") : file.error().message;
  };
  EXPECT_NE(complaint("x_mm,y_mm,z_mm\n1,2,3\n").find("'joint_1_deg' is missing"), std::string::npos);
  EXPECT_NE(complaint("joint_1_deg\n1\n").find("neither x_mm"), std::string::npos);
  EXPECT_NE(complaint("joint_1_deg,x_mm,y_mm,z_mm\n").find("no samples"), std::string::npos);
  EXPECT_NE(
      complaint(
          "joint_1_deg,x_mm,y_mm,z_mm,cov_xx_mm2,cov_xy_mm2,cov_xz_mm2,cov_yy_mm2,cov_yz_mm2,cov_zz_mm2\n"
          "1,1,1,1,1,2,0,1,0,1\n")
          .find("not positive definite"),
      std::string::npos);
  EXPECT_NE(complaint("joint_1_deg,x_mm,y_mm,z_mm\n1e8,1,1,1\n").find("joint_1_deg is 1e+08; at most"),
            std::string::npos);
  EXPECT_NE(complaint("joint_1_deg,x_mm,y_mm,z_mm\n1,1,1,1e200\n").find("z_mm is 1e+200; at most 1e+11"),
            std::string::npos);
}

TEST(ArmSamples, RowsInWhichTheTrackerSawNothingAreLeftOut) {
  const std::string head = "joint_1_deg,x_mm,y_mm,z_mm\n";
  const auto file = from_text(head + "1,1,2,3\n2,,,\n3,nan,nan,nan\n4,4,5,6\n", read_arm_samples);
  ASSERT_TRUE(file.has_value()) << file.error().message;
  EXPECT_EQ(file->left_out, 2u);
  ASSERT_EQ(file->observations.size(), 2u);
  EXPECT_EQ(file->observations[1].line, 5);
  const auto none = from_text(head + "1,,,\n", read_arm_samples);
  ASSERT_FALSE(none.has_value());
  EXPECT_NE(none.error().message.find("seen in none of 1 row"), std::string::npos);
  EXPECT_FALSE(from_text(head + "1,1,2,\n", read_arm_samples)) << "a part of a place is no place";
}

TEST(ArmSamples, OnlyColumnsThatAreReadMustHoldNumbers) {
  const auto complaint = [](const std::string& content) {
    const auto samples = from_text(content, read_arm_samples);
    return samples ? "none" : samples.error().message;
  };
  const std::string head = "joint_1_deg,x_mm,y_mm,z_mm,operator,time_s\n";
  const auto file = from_text(head + "1,2,3,4,me,0\n", read_arm_samples);
  ASSERT_TRUE(file.has_value()) << file.error().message;
  EXPECT_NE(complaint(head + "1,2,x,4,me,0\n").find("y_mm is 'x', a number is expected"), std::string::npos);
  EXPECT_NE(complaint(head + "1,2,3,4,me,\n").find("time_s is '', a number is expected"), std::string::npos);
  const std::string marker =
      "joint_1_deg,marker_x_mm,marker_y_mm,marker_z_mm,marker_qw,marker_qx,marker_qy,marker_qz,systematic_"
      "mm\n";
  EXPECT_NE(complaint(marker + "1,2,3,4,1,0,0,?,0\n").find("marker_qz is '?', a number is expected"),
            std::string::npos);
  EXPECT_NE(complaint(marker + "1,2,3,4,1,0,0,0,much\n").find("systematic_mm is 'much', a number"),
            std::string::npos);
}

TEST(PointFile, OtherColumnsMayHoldText) {
  const auto file = from_text("id,x_mm,y_mm,z_mm,ow,label,desc\nMarkups_1,1,2,3,,F-1,\n", read_points);
  ASSERT_TRUE(file.has_value()) << file.error().message;
  EXPECT_EQ(file->labels[0], "F-1");
  EXPECT_FALSE(from_text("x_mm,y_mm,z_mm,frame\n1,b,3,w\n", read_points).has_value());
  EXPECT_FALSE(from_text("x_mm,y_mm,z_mm,weight\n1,2,3,heavy\n", read_points).has_value());
}

TEST(PointFile, LabelsUnitsAndWeightsAreRead) {
  const auto file = from_text("landmark,x_m,y_m,z_m,weight\nnose,1,2,3,0.5\nchin,4,5,6,1\n", read_points);
  ASSERT_TRUE(file.has_value()) << file.error().message;
  EXPECT_EQ(file->labels[0], "nose");
  EXPECT_EQ(file->points[1].z(), 6.0);
  EXPECT_EQ(file->weights[0], 0.5);
  EXPECT_DOUBLE_EQ(from_text("x_mm,y_mm,z_mm\n1,2,3\n", read_points)->points[0].x(), 0.001);
  EXPECT_FALSE(from_text("x_mm,y_mm\n1,2\n", read_points).has_value());
  EXPECT_FALSE(from_text("x_mm,y_mm,z_mm\n", read_points).has_value());
  EXPECT_FALSE(from_text("x_m,y_m,z_m\n1,2,-1e200\n", read_points).has_value())
      << "finite, its square is not";
  EXPECT_FALSE(from_text("x_m,y_m,z_m,weight\n1,2,3,1e200\n", read_points).has_value());
}

}  // namespace
}  // namespace palpate::device
