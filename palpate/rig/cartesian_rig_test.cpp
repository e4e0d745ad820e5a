// The rig of an arm that states its place: what its file says, and when the check of its forces is void.
#include <gtest/gtest.h>

#include "palpate/core/random.h"
#include "palpate/rig/rig.h"

namespace palpate::rig {
namespace {

Rig cartesian_rig() {
  Rig rig;
  Random random(3, "rig/cartesian");
  rig.arm.emplace();
  auto& model = rig.arm->model;
  model = {.kind = device::ArmModel::Kind::cartesian, .name = "delta"};
  model.places = {{{-0.07, 0.09}, {-0.25, -0.09}, {0.08, 0.24}}};
  model.correction.centre = {0.01, -0.17, 0.16};
  model.correction.reach = 0.08;
  rig.nominal_arm = model;
  for (double& term : model.correction.terms) term = random.normal(0.001);
  rig.arm->correction = device::JointCorrection::none(3);
  rig.arm->rest_readings = Vector3(0.01, -0.17, 0.09);
  rig.arm->covariance = 1e-6 * Eigen::MatrixXd::Identity(39, 39);
  return rig;
}

TEST(CartesianRig, AnArmThatStatesItsPlaceIsReadAsItWasWritten) {
  const Rig rig = cartesian_rig();
  const std::string text = rig_text(rig);
  EXPECT_EQ(text.find("gains = "), text.find("gimbal_gains = ") + 7) << "no joints, no gains of theirs";
  EXPECT_EQ(text.find("rest_readings_deg"), std::string::npos);
  const auto again = parse_rig(text, "rig.toml");
  ASSERT_TRUE(again) << again.error().message;
  EXPECT_EQ(rig_text(*again), text);
  EXPECT_EQ(again->arm->model.kind, device::ArmModel::Kind::cartesian);
  EXPECT_EQ(again->nominal_arm.kind, device::ArmModel::Kind::cartesian);
  EXPECT_TRUE(again->nominal_arm.correction.terms.isZero());
  EXPECT_LT((again->arm->model.correction.terms - rig.arm->model.correction.terms).norm(), 1e-15);
  EXPECT_LT((again->arm->rest_readings - rig.arm->rest_readings).norm(), 1e-15);
  EXPECT_EQ(again->arm->correction.gain, Eigen::VectorXd::Ones(3));
  EXPECT_EQ(covariance_order(again->arm->model).size(), 39u);
  EXPECT_EQ(covariance_order(again->arm->model)[15], "strain_xx");
  const auto complains = [&](const std::string& from, const std::string& to, const std::string& words) {
    std::string changed = text;
    const auto at = changed.rfind(from);
    ASSERT_NE(at, std::string::npos) << from;
    const auto refused = parse_rig(changed.replace(at, from.size(), to), "rig.toml");
    ASSERT_FALSE(refused) << words;
    EXPECT_NE(refused.error().message.find(words), std::string::npos) << refused.error().message;
  };
  complains("rest_readings_mm", "rest_readings_deg", "rest_readings_mm");
  complains("correction_mm = [", "correction_mm = [1, ", "correction_mm");
  complains("range_mm = [[", "range_mm = [[500, 1], [", "range_mm");
}

// Another correction, another zero: the check of the forces is void; a hand's little is not.
TEST(CartesianRig, TheCheckOfForcesOfAnArmThatStatesItsPlaceKnowsItsZero) {
  Rig rig = cartesian_rig();
  rig.forces = force_calibration_of(rig, "delta 7");
  rig.forces->joint_gains = Vector3::Ones();
  const auto again = parse_rig(rig_text(rig), "rig.toml");
  ASSERT_TRUE(again) << again.error().message;
  EXPECT_TRUE(again->forces->states_place);
  EXPECT_EQ(void_reason(*again, "delta 7"), "");
  Rig moved = *again;
  moved.arm->rest_readings[2] += 0.0005;
  EXPECT_EQ(void_reason(moved, ""), "");
  moved.arm->rest_readings[2] += 0.001;
  EXPECT_NE(void_reason(moved, "").find("joint 3 is 91.500 mm, and was 90.000"), std::string::npos)
      << void_reason(moved, "");
  moved = *again;
  moved.arm->model.correction.terms[3] += 0.004;
  EXPECT_NE(void_reason(moved, "").find("has other lengths"), std::string::npos);
}

}  // namespace
}  // namespace palpate::rig
