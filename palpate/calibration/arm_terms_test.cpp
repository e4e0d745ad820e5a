// The terms beyond gains and offsets: delay of a moving recording, quadratic joint terms, hysteresis; what
// --free auto makes of them; predicted errors.
#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "palpate/calibration/arm_motion.h"
#include "palpate/calibration/arm_prediction.h"
#include "palpate/calibration/arm_validation.h"
#include "palpate/calibration/internal/arm_problem.h"
#include "palpate/core/units.h"
#include "palpate/math/random_vector.h"

namespace palpate::calibration {
namespace {

constexpr double kNoise = 2e-4;  // m per axis

// A PHANToM moved freely before a tracker, whose frames come 10 ms apart and `delay` late.
struct MovingArm {
  explicit MovingArm(std::uint64_t seed) : random(seed, "moving arm") {
    truth.gain = Vector3::Ones() + normal3(random, 0.012);
    truth.offset = normal3(random, 0.02);
    truth.offset[0] = 0.0;
    truth.X_world_base = {rotation_from_xyz(Vector3(0.03, -0.07, 0.01)), Vector3(0.1, -1.4, 1.75)};
    truth.tip_in_marker = Vector3(0.004, -0.018, -0.118);
    truth.tip_known = true;
    for (double& phase : phases) phase = random.uniform(0.0, 6.28);
  }

  Vector3 psi_at(double t) const {
    Vector3 psi;
    const double rates[]{1.9, 2.6, 3.1};  // rad/s
    for (int j = 0; j < 3; ++j)
      psi[j] = (j == 0 ? 0.0 : 0.5) + 0.35 * std::sin(rates[j] * t + phases[static_cast<std::size_t>(j)]) +
               0.15 * std::sin(1.7 * rates[j] * t);
    return psi;
  }
  Vector3 gimbal_at(double t) const {
    return {0.5 * std::sin(1.3 * t), 0.4 * std::cos(1.1 * t), std::sin(0.7 * t)};
  }

  // Angles of the joints; hysteresis by the sign of the motion.
  Vector3 theta_at(double t) const {
    const Vector3 psi = psi_at(t);
    Vector3 theta = truth.gain.cwiseProduct(psi) + truth.offset;
    if (truth.quadratic.size() > 0) theta += truth.quadratic.cwiseProduct(psi.cwiseAbs2());
    if (truth.hysteresis.size() > 0) {
      const Vector3 motion = psi_at(t + 1e-4) - psi_at(t - 1e-4);
      for (int j = 0; j < 3; ++j) theta[j] += (motion[j] > 0 ? 1.0 : -1.0) * truth.hysteresis[j];
    }
    return theta;
  }

  std::vector<device::ArmObservation> record(int count, double delay, double noise = kNoise) {
    std::vector<device::ArmObservation> samples;
    for (int i = 0; i < count; ++i) {
      const double t = 0.01 * i;
      device::ArmObservation sample;
      sample.time_s = 100.0 + t;
      sample.joints = psi_at(t);
      sample.gimbal = gimbal_at(t);
      const Vector3 theta = theta_at(t - delay);
      const Vector3 tip = (truth.X_world_base * device::phantom_tip(theta, truth.model.lengths)).m;
      const Quaternion turn =
          truth.X_world_base.rotation * device::phantom_stylus(theta, gimbal_at(t - delay));
      sample.marker = Pose<World, TipMarker>{turn, tip - turn * truth.tip_in_marker + normal3(random, noise)};
      sample.covariance = std::max(noise * noise, 1e-20) * Matrix3::Identity();
      sample.systematic = 0.0;
      samples.push_back(sample);
    }
    return samples;
  }

  // Every fifth of a second of the motion, as if held still there.
  std::vector<device::ArmObservation> poses(int count) {
    const auto all = record(20 * count, 0.0);
    std::vector<device::ArmObservation> some;
    for (std::size_t i = 0; i < all.size(); i += 20) some.push_back(all[i]);
    return some;
  }

  Random random;
  ArmSolution truth;
  std::array<double, 3> phases{};
};

ArmFree free_with(bool ArmFree::*term) {
  ArmFree free{.gains = true, .offsets = true, .lengths = false, .tip = true};
  free.*term = true;
  return free;
}

TEST(ArmMotions, FollowASmoothMotionBetweenTheRows) {
  MovingArm arm(1);
  const auto samples = arm.record(200, 0.0, 0.0);
  const auto motions = arm_motions(samples, 0.0137);
  for (std::size_t i = 10; i < 190; ++i) {
    const double t = 0.01 * static_cast<double>(i) - 0.0137;
    EXPECT_LT((motions[i].joints - arm.psi_at(t)).norm(), 2e-6);
    EXPECT_LT((motions[i].rate - (arm.psi_at(t + 1e-5) - arm.psi_at(t - 1e-5)) / 2e-5).norm(), 5e-3);
  }
}

TEST(ArmMotions, DoNotDependOnTheOrderOfTheRows) {
  MovingArm arm(2);
  auto samples = arm.record(50, 0.0);
  const auto forward = arm_motions(samples, 0.02);
  std::reverse(samples.begin(), samples.end());
  const auto backward = arm_motions(samples, 0.02);
  for (std::size_t i = 0; i < 50; ++i) {
    EXPECT_EQ(forward[i].joints, backward[49 - i].joints);
    EXPECT_EQ(forward[i].direction, backward[49 - i].direction);
  }
}

TEST(ArmMotions, PosesFarApartAreAtRestAndKnowWhereTheyCameFrom) {
  MovingArm arm(3);
  auto samples = arm.record(3, 0.0);
  for (std::size_t i = 0; i < 3; ++i) samples[i].time_s = static_cast<double>(i);
  samples[0].joints = Vector3(0.0, 0.5, 0.2);
  samples[1].joints = Vector3(0.1, 0.4, 0.2);
  samples[2].joints = Vector3(0.0, 0.3, 0.2);
  const auto motions = arm_motions(samples, 0.05);
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_EQ(motions[i].joints, samples[i].joints);
    EXPECT_EQ(motions[i].rate.norm(), 0.0);
  }
  EXPECT_EQ(motions[0].direction, Vector3(0, 0, 0));
  EXPECT_EQ(motions[1].direction, Vector3(1, -1, 0));
  EXPECT_EQ(motions[2].direction, Vector3(-1, -1, 0));
  EXPECT_FALSE(taken_in_motion(samples));
}

// 600 frames of 0.2 mm noise at 0.3 m/s rms tell the delay to about 0.03 ms.
TEST(ArmDelay, IsFoundAsWellAsItsDeviationSays) {
  for (const double delay : {0.010, -0.035, 0.12}) {
    MovingArm arm(4);
    const auto estimate =
        calibrate_arm(arm.record(600, delay), arm.truth.model, {.free = free_with(&ArmFree::delay)});
    ASSERT_TRUE(estimate.has_value()) << estimate.error().message;
    const auto& names = estimate->value.parameters;
    const auto at = std::find(names.begin(), names.end(), "delay") - names.begin();
    ASSERT_LT(at, static_cast<std::ptrdiff_t>(names.size()));
    const double deviation = estimate->standard_deviation(at);
    EXPECT_LT(deviation, 1e-4);
    EXPECT_NEAR(estimate->value.delay_s, delay, 4.0 * deviation);
    EXPECT_LT(mean_norm(arm_errors(estimate->value, arm.record(600, delay, 0.0))), 1e-4);  // half the noise
  }
}

TEST(ArmDelay, NeedsMotionAndTimes) {
  MovingArm arm(5);
  auto samples = arm.record(60, 0.01);
  for (std::size_t i = 0; i < samples.size(); ++i) samples[i].time_s = static_cast<double>(i);
  auto refused = calibrate_arm(samples, arm.truth.model, {.free = free_with(&ArmFree::delay)});
  ASSERT_FALSE(refused.has_value());
  EXPECT_NE(refused.error().message.find("motion"), std::string::npos);
  samples[3].time_s.reset();
  refused = calibrate_arm(samples, arm.truth.model, {.free = free_with(&ArmFree::delay)});
  ASSERT_FALSE(refused.has_value());
  EXPECT_NE(refused.error().message.find("time_s"), std::string::npos);
  refused = calibrate_arm(arm.record(60, 0.01), arm.truth.model,
                          {.method = ArmMethod::eq7, .free = free_with(&ArmFree::delay)});
  EXPECT_FALSE(refused.has_value());
}

TEST(ArmQuadratic, IsFoundWhereItIsAndNoneWhereThereIsNone) {
  MovingArm arm(6);
  arm.truth.quadratic = Vector3(0.01, -0.02, 0.015);
  const auto estimate =
      calibrate_arm(arm.record(400, 0.0), arm.truth.model, {.free = free_with(&ArmFree::quadratic)});
  ASSERT_TRUE(estimate.has_value()) << estimate.error().message;
  EXPECT_LT((estimate->value.quadratic - arm.truth.quadratic).norm(), 4e-3);
  // the truth's own prediction includes the term
  EXPECT_LT((predict_tip(estimate->value, Vector3(0.3, 0.8, 0.1)).m -
             predict_tip(arm.truth, Vector3(0.3, 0.8, 0.1)).m)
                .norm(),
            2.5e-4);
  MovingArm straight(6);
  const auto none = calibrate_arm(straight.record(400, 0.0), straight.truth.model,
                                  {.free = free_with(&ArmFree::quadratic)});
  ASSERT_TRUE(none.has_value());
  EXPECT_LT(none->value.quadratic.norm(), 4e-3);
}

TEST(ArmHysteresis, IsFoundByTheDirectionOfTheMotion) {
  MovingArm arm(7);
  arm.truth.hysteresis = Vector3(0.001, 0.0015, -0.0005);
  const auto samples = arm.record(400, 0.0);
  const auto estimate = calibrate_arm(samples, arm.truth.model, {.free = free_with(&ArmFree::hysteresis)});
  ASSERT_TRUE(estimate.has_value()) << estimate.error().message;
  EXPECT_LT((estimate->value.hysteresis - arm.truth.hysteresis).norm(), 3e-4);
  const auto without = calibrate_arm(
      samples, arm.truth.model, {.free = {.gains = true, .offsets = true, .lengths = false, .tip = true}});
  EXPECT_LT(mean_norm(estimate->residuals), 0.9 * mean_norm(without->residuals));
}

// Derivatives of all terms against central differences.
TEST(ArmProblem, DerivativesAgreeWithDifferences) {
  MovingArm arm(8);
  arm.truth.quadratic = Vector3(0.01, -0.02, 0.015);
  arm.truth.hysteresis = Vector3(0.001, 0.0015, -0.0005);
  const auto samples = arm.record(40, 0.01);
  const auto motions = arm_motions(samples, 0.01);
  ArmFreedom all{.base = true,
                 .gains = true,
                 .offsets = true,
                 .quadratic = true,
                 .hysteresis = true,
                 .delay = true,
                 .lengths = true,
                 .tip = true};
  const auto parameters = list_parameters(arm.truth.model, all);
  const auto P = static_cast<Eigen::Index>(parameters.size());
  Eigen::Matrix3Xd J(3, P);
  arm_residual(arm.truth, samples[20], motions[20], parameters, &J);
  for (Eigen::Index k = 0; k < P; ++k) {
    const double h = 1e-6;
    Vector3 side[2];
    for (int s = 0; s < 2; ++s) {
      Eigen::VectorXd x = Eigen::VectorXd::Zero(P);
      x[k] = s == 0 ? h : -h;
      ArmMotion motion = motions[20];
      if (parameters[static_cast<std::size_t>(k)].part == ArmParameter::Part::delay)
        motion = arm_motions(samples, 0.01 + x[k])[20];
      side[s] = arm_residual(moved(arm.truth, parameters, x), samples[20], motion, {}, nullptr);
    }
    EXPECT_LT((J.col(k) - (side[0] - side[1]) / (2 * h)).norm(), 1e-6 * (1.0 + J.col(k).norm()))
        << parameters[static_cast<std::size_t>(k)].name;
  }
}

TEST(ArmChoice, FreesWhatTheDataAskFor) {
  MovingArm arm(9);
  arm.truth.quadratic = Vector3(0.02, -0.02, 0.02);
  const auto choice = choose_free(arm.record(300, 0.015), arm.truth.model, {.free = {.tip = true}});
  ASSERT_TRUE(choice.has_value()) << choice.error().message;
  EXPECT_TRUE(choice->free.delay);
  EXPECT_TRUE(choice->free.quadratic);
  EXPECT_FALSE(choice->free.hysteresis) << choice->why;
  EXPECT_NE(choice->why.find("delay lowers it"), std::string::npos) << choice->why;
}

TEST(ArmChoice, LeavesAloneWhatDoesNotHelp) {
  MovingArm arm(10);
  const auto choice = choose_free(arm.record(300, 0.0), arm.truth.model, {.free = {.tip = true}});
  ASSERT_TRUE(choice.has_value()) << choice.error().message;
  EXPECT_FALSE(choice->free.quadratic) << choice->why;
  EXPECT_FALSE(choice->free.hysteresis) << choice->why;
  EXPECT_FALSE(choice->free.lengths) << choice->why;
}

// The tip's predicted covariance against where it really came out, over 80 recordings: the mean square in
// units of the covariance is 3, sd of one 2.4, of the mean of 80 0.27.
TEST(ArmPrediction, CoversTheTruth) {
  double square = 0.0;
  for (std::uint64_t seed = 0; seed < 80; ++seed) {
    MovingArm arm(100 + seed);
    const auto estimate =
        calibrate_arm(arm.poses(70), arm.truth.model,
                      {.free = {.gains = true, .offsets = true, .lengths = false, .tip = true}});
    ASSERT_TRUE(estimate.has_value()) << estimate.error().message;
    const Vector3 psi(0.5, 1.0, 0.9);
    const Vector3 error = predict_tip(estimate->value, psi).m - predict_tip(arm.truth, psi).m;
    square += error.dot(predicted_covariance(*estimate, psi).ldlt().solve(error)) / 80;
  }
  EXPECT_NEAR(square, 3.0, 0.8);
}

TEST(ArmPrediction, TheMapIsWorstAtAnEndOfTheReach) {
  MovingArm arm(11);
  const auto samples = arm.poses(70);
  const auto estimate = calibrate_arm(samples, arm.truth.model);
  ASSERT_TRUE(estimate.has_value());
  const auto map = predicted_error_map(*estimate, samples);
  ASSERT_EQ(map.places.size(), 343u);
  EXPECT_GT(map.worst.sd, map.rms);
  for (const auto& place : map.places) EXPECT_LE(place.sd, map.worst.sd);
  EXPECT_NEAR(map.worst.sd, std::sqrt(predicted_covariance(*estimate, map.worst.psi).trace()), 1e-12);
}

// The same numbers whatever the rows' order, and for quaternions of the other sign.
TEST(ArmCalibrationInvariance, OrderOfRowsAndSignOfQuaternions) {
  MovingArm arm(12);
  auto samples = arm.record(120, 0.01);
  for (auto& sample : samples) sample.systematic.reset();  // unknown: to be judged
  const ArmOptions options{.free = free_with(&ArmFree::delay)};
  const auto first = calibrate_arm(samples, arm.truth.model, options);
  std::reverse(samples.begin(), samples.end());
  std::swap(samples[3], samples[77]);
  for (std::size_t i = 0; i < samples.size(); i += 3) samples[i].marker->rotation.coeffs() *= -1.0;
  const auto second = calibrate_arm(samples, arm.truth.model, options);
  ASSERT_TRUE(first.has_value() && second.has_value());
  EXPECT_LT((first->value.tip_in_marker - second->value.tip_in_marker).norm(), 1e-9);
  EXPECT_LT((first->value.X_world_base.translation - second->value.X_world_base.translation).norm(), 1e-9);
  EXPECT_NEAR(first->value.delay_s, second->value.delay_s, 1e-9);
  // A hundred of the places and no more judge the tracker's systematic error: the same hundred.
  EXPECT_GT(first->value.noise.field_share, 0.0);
  EXPECT_LT((first->covariance - second->covariance).norm(), 1e-6 * first->covariance.norm());
}

}  // namespace
}  // namespace palpate::calibration
