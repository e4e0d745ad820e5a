#include "palpate/device/arm_model.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <numbers>

#include "palpate/core/file.h"
#include "palpate/core/random.h"
#include "tests/scratch_folder.h"

namespace palpate::device {
namespace {

ArmModel random_dh(Random& random) {
  ArmModel model;
  model.kind = ArmModel::Kind::dh;
  for (int j = 0; j < 6; ++j)
    model.joints.push_back({random.normal(0.3), random.normal(), random.normal(0.2), random.normal(0.1)});
  model.tool = {0.03, -0.05, 0.1};
  return model;
}

// Product of 4x4 matrices written out element by element: independent of the vector form in the module.
Vector3 by_matrices(const ArmModel& model, const Eigen::VectorXd& theta) {
  Eigen::Matrix4d T = Eigen::Matrix4d::Identity();
  for (std::size_t j = 0; j < model.joints.size(); ++j) {
    const auto& row = model.joints[j];
    const double t = theta[static_cast<Eigen::Index>(j)] + row.theta_offset;
    const double c = std::cos(t), s = std::sin(t), ca = std::cos(row.alpha), sa = std::sin(row.alpha);
    Eigen::Matrix4d A;
    A << c, -s * ca, s * sa, row.a * c, s, c * ca, -c * sa, row.a * s, 0, sa, ca, row.d, 0, 0, 0, 1;
    T = T * A;
  }
  return (T * model.tool.homogeneous()).head<3>();
}

TEST(ArmModel, DenavitHartenbergRowsAgreeWithTheTextbookMatrices) {
  Random random(1);
  for (int n = 0; n < 20; ++n) {
    const auto model = random_dh(random);
    const Eigen::VectorXd theta =
        Eigen::VectorXd::NullaryExpr(6, [&](Eigen::Index) { return random.normal(); });
    EXPECT_NEAR((arm_tip(model, theta).m - by_matrices(model, theta)).norm(), 0.0, 1e-14);
  }
}

// Every column of the Jacobian against central differences (error h^2 and 1e-16 / h).
TEST(ArmModel, JacobianAgreesWithFiniteDifferences) {
  Random random(2);
  const double h = 1e-6;
  for (int kind = 0; kind < 2; ++kind) {
    ArmModel model = kind == 0 ? ArmModel{} : random_dh(random);
    model.lengths = {0.2, 0.17};
    const Eigen::VectorXd theta =
        Eigen::VectorXd::NullaryExpr(model.joint_count(), [&](Eigen::Index) { return random.normal(0.5); });
    ArmJacobian J;
    EXPECT_NEAR((arm_tip(model, theta, J).m - arm_tip(model, theta).m).norm(), 0.0, 1e-15);
    const auto numeric = [&](auto change) {
      ArmModel up = model, down = model;
      Eigen::VectorXd theta_up = theta, theta_down = theta;
      change(up, theta_up, h);
      change(down, theta_down, -h);
      return Vector3((arm_tip(up, theta_up).m - arm_tip(down, theta_down).m) / (2 * h));
    };
    for (Eigen::Index j = 0; j < model.joint_count(); ++j) {
      EXPECT_NEAR((J.theta.col(j) - numeric([&](ArmModel&, auto& t, double s) { t[j] += s; })).norm(), 0,
                  1e-9);
      if (kind == 0) continue;
      const auto at = static_cast<std::size_t>(j);
      EXPECT_NEAR((J.a.col(j) - numeric([&](ArmModel& m, auto&, double s) { m.joints[at].a += s; })).norm(),
                  0, 1e-9);
      EXPECT_NEAR((J.d.col(j) - numeric([&](ArmModel& m, auto&, double s) { m.joints[at].d += s; })).norm(),
                  0, 1e-9);
      EXPECT_NEAR(
          (J.alpha.col(j) - numeric([&](ArmModel& m, auto&, double s) { m.joints[at].alpha += s; })).norm(),
          0, 1e-9);
    }
    if (kind == 0) {
      EXPECT_NEAR(
          (J.lengths.col(0) - numeric([](ArmModel& m, auto&, double s) { m.lengths.l1 += s; })).norm(), 0,
          1e-9);
      EXPECT_NEAR(
          (J.lengths.col(1) - numeric([](ArmModel& m, auto&, double s) { m.lengths.l2 += s; })).norm(), 0,
          1e-9);
    } else {
      for (int i = 0; i < 3; ++i)
        EXPECT_NEAR((J.tool.col(i) - numeric([i](ArmModel& m, auto&, double s) { m.tool[i] += s; })).norm(),
                    0, 1e-9);
    }
  }
}

Expected<ArmModel> from_text(const std::string& text) {
  const ScratchFolder scratch;
  const auto path = scratch / "arm.toml";
  EXPECT_TRUE(write_file(path, text).has_value());
  return read_arm_model(path.string());
}

TEST(ArmModel, IsReadFromToml) {
  const auto model = from_text(
      "name = 'two'\ntype = 'dh'\ntool_mm = [0, 0, 50]\n[[joint]]\na_mm = 100\nalpha_deg = 90\n"
      "d_mm = 10\ntheta_offset_deg = 180\n[[joint]]\na_mm = 1\nalpha_deg = 0\nd_mm = 2\n");
  ASSERT_TRUE(model.has_value()) << model.error().message;
  EXPECT_EQ(model->name, "two");
  ASSERT_EQ(model->joint_count(), 2);
  EXPECT_DOUBLE_EQ(model->joints[0].a, 0.1);
  EXPECT_DOUBLE_EQ(model->joints[0].theta_offset, std::numbers::pi);
  EXPECT_TRUE(model->tool_known);
  EXPECT_DOUBLE_EQ(model->tool.z(), 0.05);
  EXPECT_TRUE(read_arm_model("phantom-premium-1.5").has_value());
}

TEST(ArmModel, UnknownKeysAndMissingRowsAreWrongUse) {
  const auto unknown = from_text("type = 'dh'\n[[joint]]\na_mm = 1\nalpha_deg = 0\nd_mm = 2\nbeta_deg = 1\n");
  ASSERT_FALSE(unknown.has_value());
  EXPECT_EQ(unknown.error().kind, Error::Kind::wrong_use);
  EXPECT_NE(unknown.error().message.find(":6: unknown key 'joint[1].beta_deg'"), std::string::npos)
      << unknown.error().message;
  const std::string row = "[[joint]]\na_mm = 1\nalpha_deg = 0\nd_mm = 2\n";
  const auto turned = from_text("type = 'dh'\ntool_qwxyz = [1, 1, 0, 0]\n" + row);
  ASSERT_FALSE(turned.has_value());
  EXPECT_NE(turned.error().message.find(":2: tool_qwxyz"), std::string::npos) << turned.error().message;
  const auto backwards = from_text("type = 'dh'\n" + row + "range_deg = [90, -90]\n");
  ASSERT_FALSE(backwards.has_value());
  EXPECT_NE(backwards.error().message.find(":6: joint[1].range_deg"), std::string::npos)
      << backwards.error().message;
  EXPECT_FALSE(from_text("type = 'dh'\n").has_value());
  EXPECT_FALSE(from_text("type = 'scara'\n").has_value());
  EXPECT_FALSE(read_arm_model("no-such-arm").has_value());
}

}  // namespace
}  // namespace palpate::device
