#include "palpate/calibration/gimbal.h"

#include <gtest/gtest.h>

#include "palpate/core/random.h"
#include "palpate/core/units.h"
#include "palpate/geometry/random_vector.h"

namespace palpate {
namespace {

ArmSolution an_arm() {
  ArmSolution arm;
  arm.gain = Vector3(1.01, 0.99, 1.005);
  arm.offset = Vector3(0.0, 0.02, -0.015);
  arm.X_world_base = {rotation_from_xyz({0.02, -0.6, 0.01}), {0.1, -1.4, 1.7}};
  return arm;
}

GimbalSolution a_gimbal() {
  GimbalSolution truth;
  truth.correction = {{1.012, 0.985, 1.02}, {0.05, -0.03, 0.21}};
  // Any turn without a part about z.
  truth.R_tip_marker = Quaternion(0.4, -0.9, 0.13, 0.0).normalized();
  return truth;
}

// Readings of the joints and, turned by noise, the marker.
std::vector<ArmObservation> samples_of(const GimbalSolution& truth, int count, double noise,
                                       std::uint64_t seed, double roll = 2.0) {
  const ArmSolution arm = an_arm();
  Random random(seed, "test/gimbal");
  std::vector<ArmObservation> samples;
  for (int i = 0; i < count; ++i) {
    ArmObservation sample;
    const Vector3 psi = uniform3(random, 0.6);
    sample.joints = psi;
    sample.gimbal =
        Vector3(random.uniform(-1.0, 1.0), random.uniform(-1.0, 1.0), random.uniform(-roll, roll));
    const Vector3 theta = arm.gain.cwiseProduct(sample.joints) + arm.offset;
    const Quaternion R = arm.X_world_base.rotation *
                         phantom_stylus(theta, truth.correction.apply(*sample.gimbal)) * truth.R_tip_marker *
                         so3_exp(normal3(random, noise));
    sample.marker = Pose<World, TipMarker>{R, Vector3::Zero()};
    samples.push_back(sample);
  }
  return samples;
}

TEST(Gimbal, ExactReadingsGiveTheExactGimbal) {
  const auto truth = a_gimbal();
  const auto found = calibrate_gimbal(samples_of(truth, 12, 0.0, 1), an_arm());
  ASSERT_TRUE(found) << found.error().message;
  EXPECT_LT((found->value.correction.gain - truth.correction.gain).norm(), 1e-8);
  EXPECT_LT((found->value.correction.offset - truth.correction.offset).norm(), 1e-8);
  EXPECT_LT(angle_between(found->value.R_tip_marker, truth.R_tip_marker), 1e-8);
  EXPECT_EQ(found->unobservable, std::vector<std::string>{"gimbal_offset_3"});
}

TEST(Gimbal, ATwistOfTheMarkerIsTheLastJointsZero) {
  auto truth = a_gimbal();
  auto twisted = truth;
  twisted.R_tip_marker = Quaternion(Eigen::AngleAxisd(0.3, Vector3::UnitZ())) * truth.R_tip_marker;
  const auto found = calibrate_gimbal(samples_of(twisted, 12, 0.0, 1), an_arm());
  ASSERT_TRUE(found);
  EXPECT_NEAR(found->value.correction.offset[2], truth.correction.offset[2] + 0.3, 1e-8);
  EXPECT_LT(angle_between(found->value.R_tip_marker, truth.R_tip_marker), 1e-8);
}

TEST(Gimbal, ZerosFarOffAreFound) {
  auto truth = a_gimbal();
  truth.correction.offset = {0.7, -0.6, -1.2};
  const auto found = calibrate_gimbal(samples_of(truth, 40, 1e-3, 2), an_arm());
  ASSERT_TRUE(found);
  EXPECT_LT((found->value.correction.offset - truth.correction.offset).norm(), 3e-3);
}

TEST(GimbalStatistics, ErrorsAgreeWithTheCovariance) {
  const auto truth = a_gimbal();
  constexpr int kRuns = 200;
  Eigen::VectorXd squares = Eigen::VectorXd::Zero(5);
  for (int run = 0; run < kRuns; ++run) {
    const auto found =
        calibrate_gimbal(samples_of(truth, 40, 2.5e-3, 100 + static_cast<std::uint64_t>(run)), an_arm());
    ASSERT_TRUE(found);
    for (Eigen::Index k = 0; k < 5; ++k) {
      const double off = k < 3 ? found->value.correction.gain[k] - truth.correction.gain[k]
                               : found->value.correction.offset[k - 3] - truth.correction.offset[k - 3];
      squares[k] += off * off / found->covariance(k, k);
    }
  }
  for (Eigen::Index k = 0; k < 5; ++k)  // chi-square of 200: 3 standard deviations are 0.3
    EXPECT_NEAR(squares[k] / kRuns, 1.0, 0.35) << k;
}

TEST(Gimbal, AFewWrongPosesDoNotMatter) {
  const auto truth = a_gimbal();
  auto samples = samples_of(truth, 60, 2e-3, 5);
  for (std::size_t i = 0; i < 60; i += 15)
    samples[i].marker->rotation = samples[i].marker->rotation * so3_exp({0.2, -0.1, 0.3});
  const auto found = calibrate_gimbal(samples, an_arm());
  ASSERT_TRUE(found);
  EXPECT_FALSE(found->inlier[0] || found->inlier[15]);
  EXPECT_LT((found->value.correction.offset - truth.correction.offset).norm(), 4e-3);
  EXPECT_LT((found->value.correction.gain - truth.correction.gain).norm(), 4e-3);
}

// With the last joint at rest a turn about the second's axis is also one of the marker.
TEST(Gimbal, AJointThatDidNotMoveIsNamedAndLeftAlone) {
  const auto found = calibrate_gimbal(samples_of(a_gimbal(), 30, 2e-3, 6, 0.0), an_arm());
  ASSERT_TRUE(found);
  EXPECT_EQ(found->unobservable,
            (std::vector<std::string>{"gimbal_gain_3", "gimbal_offset_2", "gimbal_offset_3"}));
  EXPECT_NEAR(found->value.correction.gain[2], 1.0, 1e-6);
}

TEST(Gimbal, TooFewSamplesAndOtherArmsAreRefused) {
  const auto few = calibrate_gimbal(samples_of(a_gimbal(), 5, 0.0, 1), an_arm());
  ASSERT_FALSE(few);
  EXPECT_NE(few.error().message.find("at least 6"), std::string::npos);
  auto blind = samples_of(a_gimbal(), 12, 0.0, 1);
  for (auto& sample : blind) sample.gimbal.reset();
  EXPECT_FALSE(calibrate_gimbal(blind, an_arm()));
  auto broken = samples_of(a_gimbal(), 12, 0.0, 1);
  (*broken[3].gimbal)[1] = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(calibrate_gimbal(broken, an_arm()));
  ArmSolution robot = an_arm();
  robot.model.kind = ArmModel::Kind::dh;
  EXPECT_EQ(calibrate_gimbal(samples_of(a_gimbal(), 12, 0.0, 1), robot).error().exit_code(), 2);
}

}  // namespace
}  // namespace palpate
