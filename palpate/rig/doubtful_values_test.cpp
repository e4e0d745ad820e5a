#include "palpate/rig/doubtful_values.h"

#include <gtest/gtest.h>

namespace palpate::rig {
namespace {

// What is said of a rig with this lens, each part's words in one.
std::string said_of(const device::CameraModel& lens) {
  Rig rig;
  rig.camera = CameraCalibration{lens, {}, {}, {}};
  std::string said;
  for (const auto& doubt : doubtful_values(rig)) said += doubt.part + ": " + doubt.what + "\n";
  return said;
}

TEST(DoubtfulValues, AUsualLensIsNotDoubted) {
  device::CameraModel lens;
  EXPECT_EQ(said_of(lens), "");
  lens.distortion = {-0.28, 0.09, 0.001, -0.0005, 0.0};
  EXPECT_EQ(said_of(lens), "");
  EXPECT_TRUE(doubtful_values(Rig{}).empty());
}

TEST(DoubtfulValues, EachSlipIsNamed) {
  device::CameraModel lens;
  lens.width = 64;
  EXPECT_NE(said_of(lens).find("(319.5, 239.5) lies outside its picture of 64 x 480 px"), std::string::npos);
  lens = {};
  lens.cy = 640.0;
  EXPECT_NE(said_of(lens).find("lies outside"), std::string::npos);
  lens = {};
  lens.fx = lens.fy = 56.0;
  EXPECT_NE(said_of(lens).find("it would see 160 x 154 deg"), std::string::npos) << said_of(lens);
  lens = {};
  lens.fx = lens.fy = 5600.0;
  EXPECT_NE(said_of(lens).find("it would see 7 x 5 deg"), std::string::npos) << said_of(lens);
  lens = {};
  lens.fy = 280.0;
  EXPECT_NE(said_of(lens).find("factor of 2.00"), std::string::npos);
  lens = {};
  lens.distortion = {-0.9, 0.0, 0.0, 0.0, 0.0};
  EXPECT_NE(said_of(lens).find("turns back on itself"), std::string::npos) << said_of(lens);
}

TEST(DoubtfulValues, ADelayBetweenClocksOfDifferentOriginsIsNamed) {
  Rig rig;
  rig.delays = DelayCalibration{};
  rig.delays->camera_after_tracker_s = 0.04;
  rig.delays->tracker_after_arm_s = -2.9;
  EXPECT_TRUE(doubtful_values(rig).empty());
  rig.delays->camera_after_tracker_s = -1.7e9;
  ASSERT_EQ(doubtful_values(rig).size(), 1u);
  EXPECT_EQ(doubtful_values(rig).front().part, "delays");
  EXPECT_NE(doubtful_values(rig).front().what.find("camera_after_tracker_s is -1.7e+09 s"),
            std::string::npos);
  rig.delays->tracker_after_arm_s = 3.1;
  EXPECT_EQ(doubtful_values(rig).size(), 2u);
}

TEST(DoubtfulValues, TheSecondCameraIsJudgedByItself) {
  Rig rig;
  rig.camera = CameraCalibration{};
  rig.right_camera = CameraCalibration{};
  rig.right_camera->model.cx = -50.0;
  const auto doubts = doubtful_values(rig);
  ASSERT_EQ(doubts.size(), 1u);
  EXPECT_EQ(doubts.front().part, "right_camera");
}

TEST(DoubtfulValues, ATipThatPivotAndArmPutElsewhereIsNamed) {
  Rig rig;
  rig.tip_pivot = PivotCalibration{};
  rig.tip_pivot->tip_in_marker = Vector3(0.0, 0.01, -0.12);
  rig.arm = ArmCalibration{};
  EXPECT_TRUE(doubtful_values(rig).empty()) << "an arm without a tip of its own";
  rig.arm->tip_in_marker = Vector3(0.0, 0.01, -0.117);
  EXPECT_TRUE(doubtful_values(rig).empty());
  rig.arm->tip_in_marker = Vector3(0.0, 0.01, -0.108);
  // What is stated decides from 2 mm on.
  rig.arm->tip_in_marker = rig.tip_pivot->tip_in_marker + Vector3(0, 0.0039, 0);
  EXPECT_TRUE(doubtful_values(rig).empty()) << "nothing is stated";
  const Eigen::Index n = 2 * rig.arm->model.joint_count() + 9;
  rig.arm->covariance = Eigen::MatrixXd::Identity(n, n) * 1e-8;
  rig.tip_pivot->covariance = Matrix3::Identity() * 4e-8;
  EXPECT_EQ(doubtful_values(rig).size(), 1u) << "17 deviations of 0.22 mm";
  rig.tip_pivot->covariance(0, 0) = 1e-4;
  EXPECT_EQ(doubtful_values(rig).size(), 1u) << "across that way it may be as badly known as it likes";
  rig.tip_pivot->covariance(0, 0) = 4e-8;
  rig.tip_pivot->covariance(1, 1) = 3.6e-7;
  EXPECT_TRUE(doubtful_values(rig).empty()) << "6 of 0.61 mm along the way from one to the other";
  rig.tip_pivot->covariance(1, 1) = 4e-8;
  rig.arm->tip_in_marker = rig.tip_pivot->tip_in_marker + Vector3(0, 0.0019, 0);
  EXPECT_TRUE(doubtful_values(rig).empty());
  rig.arm->tip_in_marker = rig.tip_pivot->tip_in_marker + Vector3(0, 0.012, 0);
  const auto apart = doubtful_values(rig);
  ASSERT_EQ(apart.size(), 1u);
  EXPECT_EQ(apart.front().part, "arm");
  EXPECT_NE(apart.front().what.find("lies 12.0 mm from"), std::string::npos) << apart.front().what;
}

TEST(DoubtfulValues, ATipOutOfAStylusReachIsNamed) {
  Rig rig;
  rig.pointer_pivot = PivotCalibration{};
  rig.pointer_pivot->tip_in_marker = Vector3(0.0, 0.0, 0.59);
  EXPECT_TRUE(doubtful_values(rig).empty());
  rig.pointer_pivot->tip_in_marker = Vector3(0.0, 0.0, 0.75);
  const auto far = doubtful_values(rig);
  ASSERT_EQ(far.size(), 1u);
  EXPECT_EQ(far.front().part, "pointer_pivot");
  EXPECT_NE(far.front().what.find("is 750 mm from its marker"), std::string::npos) << far.front().what;
  rig.pointer_pivot->tip_in_marker = Vector3(0.0, 0.0, 0.00014);
  const auto near = doubtful_values(rig);
  ASSERT_EQ(near.size(), 1u);
  EXPECT_NE(near.front().what.find("is only 0.140 mm from its marker's origin"), std::string::npos);
}

}  // namespace
}  // namespace palpate::rig
