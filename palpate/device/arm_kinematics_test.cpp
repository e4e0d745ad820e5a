#include "palpate/device/arm_kinematics.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>

#include "palpate/core/random.h"
#include "palpate/math/random_vector.h"

namespace palpate::device {
namespace {

ArmModel ur5() {
  auto model = read_arm_model(std::string(PALPATE_DATA_DIR) + "/ur5_laser_tracker/ur5.toml");
  if (!model) throw std::runtime_error(model.error().message);
  model->tool = {0.01, -0.02, 0.12};
  model->tool_turn = so3_exp(Vector3(0.3, -0.2, 0.5));
  return *model;
}

ArmModel three_joints() {
  ArmModel model;
  model.kind = ArmModel::Kind::dh;
  model.name = "three";
  model.joints = {{0.0, 1.5707963267948966, 0.1, 0.0}, {0.25, 0.0, 0.0, 0.2}, {0.22, 0.1, 0.01, -0.4}};
  return model;
}

JointVector random_angles(Random& random, Eigen::Index joints) {
  JointVector theta = JointVector::filled(joints, 0.0);
  for (auto& angle : theta) angle = random.uniform(-2.0, 2.0);
  return theta;
}

// The chain as a product of four elementary motions per row, as Denavit and Hartenberg have them.
Eigen::Isometry3d product(const ArmModel& model, const JointVector& theta) {
  Eigen::Isometry3d X = Eigen::Isometry3d::Identity();
  for (Eigen::Index j = 0; j < theta.size(); ++j) {
    const DhJoint& row = model.joints[static_cast<std::size_t>(j)];
    X = X * Eigen::AngleAxisd(theta[j] + row.theta_offset, Vector3::UnitZ()) *
        Eigen::Translation3d(0.0, 0.0, row.d) * Eigen::Translation3d(row.a, 0.0, 0.0) *
        Eigen::AngleAxisd(row.alpha, Vector3::UnitX());
  }
  return X;
}

TEST(ArmKinematics, OfAPhantomIsThatOfItsFormulas) {
  Random random(1, "kinematics/phantom");
  const PhantomLengths lengths{0.21, 0.17};
  const auto arm = make_kinematics({.lengths = lengths});
  EXPECT_EQ(arm->joint_count(), 3);
  for (int i = 0; i < 50; ++i) {
    const Vector3 theta = normal3(random, 0.5), gimbal = normal3(random, 0.5);
    const auto pose = arm->pose(theta, gimbal);
    EXPECT_EQ(pose.translation, phantom_tip(theta, lengths).m);
    EXPECT_EQ(pose.rotation.coeffs(), phantom_stylus(theta, gimbal).coeffs());
    EXPECT_EQ(Matrix3(arm->jacobian(theta)), phantom_jacobian(theta, lengths));
  }
}

TEST(ArmKinematics, OfAChainIsTheProductOfItsRows) {
  Random random(2, "kinematics/chain");
  for (const ArmModel& model : {ur5(), three_joints()}) {
    const auto arm = make_kinematics(model);
    for (int i = 0; i < 50; ++i) {
      const JointVector theta = random_angles(random, model.joint_count());
      const Vector3 gimbal = normal3(random, 0.4);
      const Eigen::Isometry3d last = product(model, theta);
      const auto pose = arm->pose(theta, gimbal);
      EXPECT_LT((pose.translation - last * model.tool).norm(), 1e-14);
      const Matrix3 stylus =
          (Eigen::AngleAxisd(gimbal[0], Vector3::UnitY()) * Eigen::AngleAxisd(gimbal[1], Vector3::UnitX()) *
           Eigen::AngleAxisd(gimbal[2], Vector3::UnitZ()))
              .toRotationMatrix();
      EXPECT_LT((pose.matrix() - last.rotation() * model.tool_turn.toRotationMatrix() * stylus).norm(),
                1e-14);
      EXPECT_LT((pose.translation - arm_tip(model, theta).m).norm(), 1e-14);  // what calibration goes by
    }
  }
}

TEST(ArmKinematics, JacobiansAgreeWithFiniteDifferences) {
  Random random(3, "kinematics/jacobian");
  for (const ArmModel& model : {ur5(), three_joints(), ArmModel{}}) {
    const auto arm = make_kinematics(model);
    for (int i = 0; i < 50; ++i) {
      const JointVector theta = random_angles(random, model.joint_count());
      const TipJacobian J = arm->jacobian(theta);
      ASSERT_EQ(J.cols(), model.joint_count());
      for (Eigen::Index j = 0; j < J.cols(); ++j) {
        constexpr double kH = 1e-6;
        JointVector up = theta, down = theta;
        up[j] += kH, down[j] -= kH;
        const Vector3 numeric =
            (arm->pose(up, Vector3::Zero()).translation - arm->pose(down, Vector3::Zero()).translation) /
            (2.0 * kH);
        EXPECT_LT((J.col(j) - numeric).norm(), 1e-9);
      }
    }
  }
}

TEST(ArmKinematics, PoseAndJacobianAtOnceAreTheSameNumbers) {
  Random random(4, "kinematics/both");
  for (const ArmModel& model : {ur5(), three_joints(), ArmModel{}}) {
    const auto arm = make_kinematics(model);
    for (int i = 0; i < 20; ++i) {
      const JointVector theta = random_angles(random, model.joint_count());
      const Vector3 gimbal = normal3(random, 0.4);
      const auto [pose, J] = arm->pose_and_jacobian(theta, gimbal);
      EXPECT_EQ(pose.translation, arm->pose(theta, gimbal).translation);
      EXPECT_EQ(pose.rotation.coeffs(), arm->pose(theta, gimbal).rotation.coeffs());
      EXPECT_EQ(J, arm->jacobian(theta));
    }
  }
}

TEST(ArmKinematics, AStretchedArmHasTooLittleOfAVolume) {
  for (const ArmModel& model : {ur5(), three_joints()}) {
    const auto arm = make_kinematics(model);
    JointVector bent = JointVector::filled(model.joint_count(), 0.8);
    EXPECT_GT(manipulability(arm->jacobian(bent)), 2.0 * arm->least_manipulability()) << model.name;
  }
  // Upper arm and forearm in line: no force along them.
  ArmModel straight = three_joints();
  straight.joints[2] = {0.22, 0.0, 0.0, 0.0};
  const auto arm = make_kinematics(straight);
  EXPECT_LT(manipulability(arm->jacobian({0.1, 0.5, 0.0})), arm->least_manipulability());
  EXPECT_GT(manipulability(arm->jacobian({0.1, 0.5, 0.8})), arm->least_manipulability());
}

TEST(ArmKinematics, ChainsOfTooFewOrTooManyJointsAreRefused) {
  ArmModel model = three_joints();
  model.joints.pop_back();
  EXPECT_THROW(make_kinematics(model), std::invalid_argument);
  ASSERT_FALSE(check_runnable(model));
  EXPECT_EQ(
      check_runnable(model).error().message,
      "arm three: has 2 joints; 3 to 8 are expected, as fewer reach no volume and more are not carried");
  model.joints.resize(kMostJoints + 1);
  EXPECT_THROW(make_kinematics(model), std::invalid_argument);
  model.joints.resize(kMostJoints);
  EXPECT_TRUE(check_runnable(model));
}

TEST(Joints, MoreThanThereIsRoomForAreAnErrorAndNoOverflow) {
  EXPECT_THROW(JointVector(Eigen::VectorXd::Zero(kMostJoints + 1)), std::length_error);
  EXPECT_THROW((JointVector{1, 2, 3, 4, 5, 6, 7, 8, 9}), std::length_error);
  JointVector six = Eigen::VectorXd::LinSpaced(6, 0.0, 5.0);
  EXPECT_THROW(six = Eigen::VectorXd::Zero(20), std::length_error);
  EXPECT_EQ(six.size(), 6);
  const JointCorrection correction{JointVector{2.0, 1.0}, JointVector{0.5, -0.5}};
  EXPECT_EQ(correction.apply({1.0, 2.0}), (JointVector{2.5, 1.5}));
  EXPECT_EQ(correction.undo({2.5, 1.5}), (JointVector{1.0, 2.0}));
}

}  // namespace
}  // namespace palpate::device
