#include "palpate/calibration/gimbal.h"

#include <gtest/gtest.h>

#include "palpate/calibration/internal/arm_parameters.h"
#include "palpate/core/random.h"
#include "palpate/core/units.h"
#include "palpate/math/linear_algebra.h"
#include "palpate/math/random_vector.h"
#include "tests/chi_square.h"

namespace palpate::calibration {
namespace {

Estimate<ArmSolution> an_arm() {
  Estimate<ArmSolution> estimate;
  ArmSolution& arm = estimate.value;
  arm.gain = Vector3(1.01, 0.99, 1.005);
  arm.offset = Vector3(0.0, 0.02, -0.015);
  arm.X_world_base = {rotation_from_xyz({0.02, -0.6, 0.01}), {0.1, -1.4, 1.7}};
  return estimate;
}

GimbalSolution a_gimbal() {
  GimbalSolution truth;
  truth.correction = {{1.012, 0.985, 1.02}, {0.05, -0.03, 0.21}};
  // Any turn without a part about z.
  truth.R_tip_marker = Quaternion(0.4, -0.9, 0.13, 0.0).normalized();
  return truth;
}

// Readings of the joints and, turned by noise, the marker.
std::vector<device::ArmObservation> samples_of(const GimbalSolution& truth, int count, double noise,
                                               std::uint64_t seed, double roll = 2.0,
                                               const ArmSolution& arm = an_arm().value) {
  Random random(seed, "test/gimbal");
  std::vector<device::ArmObservation> samples;
  for (int i = 0; i < count; ++i) {
    device::ArmObservation sample;
    const Vector3 psi = uniform3(random, 0.6);
    sample.joints = psi;
    sample.gimbal =
        Vector3(random.uniform(-1.0, 1.0), random.uniform(-1.0, 1.0), random.uniform(-roll, roll));
    Vector3 theta = arm.gain.cwiseProduct(sample.joints) + arm.offset;
    if (arm.quadratic.size() > 0) theta += arm.quadratic.cwiseProduct(sample.joints.cwiseAbs2());
    const Quaternion R = arm.X_world_base.rotation *
                         device::phantom_stylus(theta, truth.correction.apply(*sample.gimbal)) *
                         truth.R_tip_marker * so3_exp(normal3(random, noise));
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

TEST(Gimbal, QuadraticTermsOfTheArmCount) {
  const auto truth = a_gimbal();
  auto arm = an_arm();
  arm.value.quadratic = Vector3(0.02, -0.03, 0.05);
  const auto found = calibrate_gimbal(samples_of(truth, 12, 0.0, 1, 2.0, arm.value), arm);
  ASSERT_TRUE(found);
  EXPECT_LT((found->value.correction.offset - truth.correction.offset).norm(), 1e-8);
}

// Squares of errors over stated deviations: gains 3, offsets 3, and the sum of the two that the marker's turn without
// a twist has.
Eigen::VectorXd squares_of_errors(const GimbalSolution& truth, const Estimate<GimbalSolution>& found) {
  Eigen::VectorXd off(9), squares(7);
  off << found.value.correction.gain - truth.correction.gain,
      found.value.correction.offset - truth.correction.offset,
      so3_log(truth.R_tip_marker.conjugate() * found.value.R_tip_marker);
  squares.head<6>() = off.head<6>().array().square() / found.covariance.diagonal().head<6>().array();
  // Along the axes that the marker's turn is free about.
  const auto marker = symmetric_eigen(found.covariance.bottomRightCorner<3, 3>());
  const Vector3 along = marker.vectors.transpose() * off.tail<3>();
  EXPECT_LT(marker.values[0], 1e-9 * marker.values[2]);
  squares[6] = along[1] * along[1] / marker.values[1] + along[2] * along[2] / marker.values[2];
  return squares;
}

TEST(GimbalStatistics, ErrorsAgreeWithTheCovariance) {
  const auto truth = a_gimbal();
  constexpr int kRuns = 1000;
  Eigen::VectorXd squares = Eigen::VectorXd::Zero(7);
  for (int run = 0; run < kRuns; ++run) {
    const auto found =
        calibrate_gimbal(samples_of(truth, 40, 2.5e-3, 100 + static_cast<std::uint64_t>(run)), an_arm());
    ASSERT_TRUE(found);
    squares += squares_of_errors(truth, *found);
  }
  // 40 turns of three components less eight parameters leave 112 freedoms to find the noise by.
  for (Eigen::Index k = 0; k < 7; ++k)
    EXPECT_TRUE(tests::is_sum_of_f(squares[k], kRuns, k < 6 ? 1 : 2, 112)) << k;
}

// The readings are of an arm a little other than the one given, as its covariance says.
TEST(GimbalStatistics, TheArmsUncertaintyIsInTheCovariance) {
  const auto truth = a_gimbal();
  auto arm = an_arm();
  arm.value.parameters = {"base_rotation_x", "base_rotation_y", "base_rotation_z", "gain_2",
                          "gain_3",          "offset_2",        "offset_3"};
  Eigen::VectorXd sd(7);
  sd << 2e-3, 1e-3, 3e-3, 4e-3, 4e-3, 5e-3, 3e-3;
  arm.covariance = sd.cwiseAbs2().asDiagonal();
  arm.covariance(0, 5) = arm.covariance(5, 0) = 0.9 * sd[0] * sd[5];
  const Eigen::MatrixXd root = arm.covariance.llt().matrixL();
  constexpr int kRuns = 1000;
  Random random(7, "test/gimbal-arm");
  Eigen::VectorXd squares = Eigen::VectorXd::Zero(7), from_readings = squares;
  for (int run = 0; run < kRuns; ++run) {
    Eigen::VectorXd x(7);
    for (auto& value : x) value = random.normal();
    const auto real = moved(arm.value, parameters_named(arm.value.model, arm.value.parameters), root * x);
    const auto samples = samples_of(truth, 40, 2.5e-3, 100 + static_cast<std::uint64_t>(run), 2.0, real);
    const auto found = calibrate_gimbal(samples, arm);
    ASSERT_TRUE(found);
    squares += squares_of_errors(truth, *found);
    Estimate<ArmSolution> as_if_exact;
    as_if_exact.value = arm.value;
    from_readings += squares_of_errors(truth, *calibrate_gimbal(samples, as_if_exact));
  }
  // What the arm is off also lies in the residuals, by which the noise is told: it counts twice in part, and what is
  // stated is cautious, not by more than a factor of two in the square.
  for (Eigen::Index k = 0; k < 7; ++k) {
    const double degrees = (k < 6 ? 1 : 2) * kRuns;
    EXPECT_TRUE(tests::is_at_most_chi_square(squares[k], degrees)) << k;
    EXPECT_GT(squares[k], 0.5 * tests::chi_square_bracket(degrees).low) << k;
  }
  // The arm taken as exact explains little of the first zero's error.
  EXPECT_GT(from_readings[3] / kRuns, 3.0);
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
  auto robot = an_arm();
  robot.value.model.kind = device::ArmModel::Kind::dh;
  EXPECT_EQ(calibrate_gimbal(samples_of(a_gimbal(), 12, 0.0, 1), robot).error().exit_code(), 2);
}

}  // namespace
}  // namespace palpate::calibration
