#include "palpate/calibration/arm.h"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <filesystem>

#include "palpate/calibration/arm_validation.h"
#include "palpate/core/units.h"
#include "palpate/math/random_vector.h"
#include "tests/chi_square.h"

namespace palpate::calibration {
namespace {

// A PHANToM with its faults, a marker on its stylus, and a tracker.
struct Laboratory {
  explicit Laboratory(std::uint64_t seed) : random(seed, "arm test") {
    truth.model.lengths = {0.215, 0.17};  // unequal on purpose
    truth.gain = Vector3::Ones() + normal3(random, 0.012);
    truth.offset = normal3(random, 0.02);
    truth.offset[0] = 0.0;  // trades with the base's turn
    truth.X_world_base = {rotation_from_xyz(Vector3(0.03, -0.07, 0.01)), Vector3(0.1, -1.4, 1.75)};
    truth.tip_in_marker = Vector3(0.004, -0.018, -0.118) + normal3(random, 0.002);
    truth.tip_known = true;
    model.lengths = truth.model.lengths;
  }

  Vector3 random_theta() {
    return {random.uniform(-0.78, 0.78), random.uniform(-0.17, 1.48), random.uniform(-0.43, 1.13)};
  }

  std::vector<device::ArmObservation> record(int count, double noise, bool markers = true) {
    std::vector<device::ArmObservation> samples;
    for (int i = 0; i < count; ++i) {
      const Vector3 theta = random_theta();
      device::ArmObservation sample;
      sample.joints = (theta - truth.offset).cwiseQuotient(truth.gain);
      const Vector3 tip = predict_tip(truth, sample.joints).m;
      const Quaternion turn =
          truth.X_world_base.rotation * device::phantom_stylus(theta, normal3(random, 0.5));
      if (markers) {
        sample.marker =
            Pose<World, TipMarker>{turn, tip - turn * truth.tip_in_marker + normal3(random, noise)};
      } else {
        sample.tip = Point<World>{tip + normal3(random, noise)};
      }
      samples.push_back(sample);
    }
    return samples;
  }

  // Mean distance to the true tip over 500 configurations not used otherwise.
  double error_to_truth(const ArmSolution& arm) const {
    Random other(99, "arm test places");
    double sum = 0.0;
    for (int i = 0; i < 500; ++i) {
      const Vector3 psi(other.uniform(-0.78, 0.78), other.uniform(-0.17, 1.48), other.uniform(-0.43, 1.13));
      sum += (predict_tip(arm, psi).m - predict_tip(truth, psi).m).norm() / 500;
    }
    return sum;
  }

  Random random;
  ArmSolution truth;
  device::ArmModel model;
};

const ArmFree kGainsOffsetsTip{.gains = true, .offsets = true, .lengths = false, .tip = true};

TEST(ArmCalibration, ExactSamplesGiveTheExactArm) {
  Laboratory lab(1);
  lab.model.lengths = {0.20955, 0.20955};  // lengths are found too
  const auto estimate = calibrate_arm(lab.record(40, 0.0), lab.model);
  ASSERT_TRUE(estimate.has_value()) << estimate.error().message;
  EXPECT_LT(lab.error_to_truth(estimate->value), 1e-11);
  EXPECT_LT((estimate->value.tip_in_marker - lab.truth.tip_in_marker).norm(), 1e-10);
  EXPECT_NEAR(estimate->value.model.lengths.l2, 0.17, 1e-10);
  EXPECT_EQ(estimate->unobservable, std::vector<std::string>{"offset_1"});
}

// Errors in the order of arm.parameters, in units of the covariance, squared; summed over seeds.
constexpr int kArms = 300;
double sum_of_squares(bool stated) {
  double sum = 0.0;
  for (std::uint64_t seed = 0; seed < kArms; ++seed) {
    Laboratory lab(100 + seed);
    auto samples = lab.record(70, 2e-4);
    if (stated)
      for (auto& sample : samples) {
        sample.covariance = 4e-8 * Matrix3::Identity();
        sample.systematic = 0.0;
      }
    const auto estimate = calibrate_arm(samples, lab.model, {.free = kGainsOffsetsTip});
    if (!estimate || estimate->value.parameters.size() != 14) return -1.0;
    const auto& arm = estimate->value;
    Eigen::VectorXd error(14);
    error << so3_log(arm.X_world_base.rotation * lab.truth.X_world_base.rotation.conjugate()),
        arm.X_world_base.translation - lab.truth.X_world_base.translation, arm.gain - lab.truth.gain,
        (arm.offset - lab.truth.offset).tail(2), arm.tip_in_marker - lab.truth.tip_in_marker;
    sum += tests::normalised_square(error, estimate->covariance);
  }
  return sum;
}

// Gains 3, offsets 2, base 6, tip 3, with the noise known.
TEST(ArmCalibrationStatistics, ErrorsAgreeWithTheCovariance) {
  EXPECT_TRUE(tests::is_chi_square(sum_of_squares(true), 14 * kArms));
}

// Where the tracker states nothing, some of the noise may be systematic: the covariance is wider, not by more
// than a factor of two in the square.
TEST(ArmCalibrationStatistics, WithoutAStatedAccuracyTheCovarianceIsCautious) {
  const double square = sum_of_squares(false);
  const auto honest = tests::chi_square_bracket(14 * kArms);
  EXPECT_LT(square, honest.low);
  EXPECT_GT(square, 0.5 * honest.low);
}

TEST(ArmCalibration, TheJointSolveBeatsEveryVariantOfThePaperWhenTheTipIsOneMillimetreOff) {
  double joint = 0.0, best = 0.0;
  for (std::uint64_t seed = 0; seed < 5; ++seed) {
    Laboratory lab(200 + seed);
    const auto samples = lab.record(70, 2e-4);
    const Vector3 wrong_tip = lab.truth.tip_in_marker + 0.001 * normal3(lab.random).normalized();
    double least = 1.0;
    for (auto method : {ArmMethod::one_pass, ArmMethod::alternating, ArmMethod::eq7}) {
      const auto estimate =
          calibrate_arm(samples, lab.model, {.method = method, .free = kGainsOffsetsTip, .tip = wrong_tip});
      ASSERT_TRUE(estimate.has_value()) << estimate.error().message;
      least = std::min(least, lab.error_to_truth(estimate->value));
    }
    const auto estimate = calibrate_arm(samples, lab.model, {.free = kGainsOffsetsTip, .tip = wrong_tip});
    ASSERT_TRUE(estimate.has_value()) << estimate.error().message;
    joint += lab.error_to_truth(estimate->value) / 5;
    best += least / 5;
  }
  EXPECT_LT(joint, 1.5e-4);  // noise 0.2 mm, 70 points: the bound of the linearised problem is about 0.08 mm
  EXPECT_LT(joint, 0.5 * best);
}

// With exact measured points all of equations 7, 8 and the joint solve have the same minimum: zero.
TEST(ArmCalibration, Eq7AndAlternatingReachTheExactArmFromMeasuredPoints) {
  Laboratory lab(3);
  const auto samples = lab.record(60, 0.0, false);
  const auto eq7 = calibrate_arm(samples, lab.model, {.method = ArmMethod::eq7});
  ASSERT_TRUE(eq7.has_value()) << eq7.error().message;
  EXPECT_LT(lab.error_to_truth(eq7->value), 1e-9);
  const auto one_pass = calibrate_arm(samples, lab.model, {.method = ArmMethod::one_pass});
  const auto alternating = calibrate_arm(samples, lab.model, {.method = ArmMethod::alternating});
  ASSERT_TRUE(one_pass.has_value() && alternating.has_value());
  EXPECT_LT(lab.error_to_truth(alternating->value), lab.error_to_truth(one_pass->value));
}

TEST(ArmCalibration, EncodersZeroedInOddPositionsAreFound) {
  for (const auto& [second, third] : {std::pair{45.0, 0.0}, {-45.0, 45.0}, {45.0, 45.0}, {0.0, -45.0}}) {
    Laboratory lab(4);
    lab.truth.offset[1] = radians_from_degrees(second);
    lab.truth.offset[2] = radians_from_degrees(third);
    const auto estimate = calibrate_arm(lab.record(70, 2e-4), lab.model, {.free = kGainsOffsetsTip});
    ASSERT_TRUE(estimate.has_value()) << estimate.error().message;
    const auto errors = arm_errors(estimate->value, lab.record(70, 0.0));
    EXPECT_LT(mean_norm(errors), 2.5e-4) << second << ' ' << third;
  }
}

TEST(ArmCalibration, OutliersAreNamedAndDoNotMatter) {
  Laboratory lab(5);
  auto samples = lab.record(100, 2e-4);
  const auto clean = calibrate_arm(samples, lab.model, {.free = kGainsOffsetsTip});
  for (std::size_t i = 0; i < samples.size(); i += 20)
    samples[i].marker->translation += 0.01 * normal3(lab.random).normalized();
  const auto dirty = calibrate_arm(samples, lab.model, {.free = kGainsOffsetsTip});
  ASSERT_TRUE(clean.has_value() && dirty.has_value());
  EXPECT_LT((predict_tip(clean->value, samples[0].joints).m - predict_tip(dirty->value, samples[0].joints).m)
                .norm(),
            1e-4);
  for (std::size_t i = 0; i < samples.size(); i += 20) EXPECT_FALSE(dirty->inlier[i]);
  EXPECT_GE(std::count(dirty->inlier.begin(), dirty->inlier.end(), true), 93);
}

// Depth four times worse than the other axes: the covariance given with the samples must help.
TEST(ArmCalibration, CovariancesOfTheSamplesWeighThem) {
  double weighted = 0.0, plain = 0.0;
  for (std::uint64_t seed = 0; seed < 10; ++seed) {
    Laboratory lab(300 + seed);
    auto samples = lab.record(70, 0.0);
    for (auto& sample : samples) {
      sample.marker->translation +=
          Vector3(lab.random.normal(1e-4), lab.random.normal(1e-4), lab.random.normal(1e-3));
      sample.covariance = Vector3(1e-8, 1e-8, 1e-6).asDiagonal();
    }
    weighted += lab.error_to_truth(calibrate_arm(samples, lab.model, {.free = kGainsOffsetsTip})->value);
    for (auto& sample : samples) sample.covariance.reset();
    plain += lab.error_to_truth(calibrate_arm(samples, lab.model, {.free = kGainsOffsetsTip})->value);
  }
  EXPECT_LT(weighted, 0.6 * plain);
}

TEST(ArmCalibration, MissingMotionIsRefusedOrNamed) {
  Laboratory lab(6);
  const auto refusal = [&](const std::vector<device::ArmObservation>& samples,
                           const ArmOptions& options = {}) {
    const auto estimate = calibrate_arm(samples, lab.model, options);
    return estimate ? std::string("none") : estimate.error().message;
  };
  EXPECT_NE(refusal({}).find("0 samples"), std::string::npos);
  EXPECT_NE(refusal(lab.record(5, 0.0)).find("5 samples"), std::string::npos);
  auto stiff = lab.record(40, 2e-4);
  for (auto& sample : stiff) {
    const Vector3 tip = (*sample.marker * Point<TipMarker>{lab.truth.tip_in_marker}).m;
    sample.marker = Pose<World, TipMarker>{Quaternion::Identity(), tip};
  }
  EXPECT_NE(refusal(stiff).find("stylus hardly turns"), std::string::npos);
  auto broken = lab.record(40, 0.0);
  broken[7].joints[1] = std::nan("");
  EXPECT_NE(refusal(broken).find("sample 8 is not finite"), std::string::npos);
  broken[7].joints = Eigen::VectorXd::Zero(6);
  EXPECT_NE(refusal(broken).find("6 joint readings"), std::string::npos);
  // A joint that never moves: its gain cannot be known, and that is said.
  auto still = lab.record(60, 2e-4, false);
  for (auto& sample : still) {
    sample.joints[0] = 0.0;
    sample.tip = Point<World>{predict_tip(lab.truth, sample.joints).m + normal3(lab.random, 2e-4)};
  }
  const auto estimate = calibrate_arm(still, lab.model, {.free = {.lengths = false}});
  ASSERT_TRUE(estimate.has_value()) << estimate.error().message;
  EXPECT_NE(std::find(estimate->unobservable.begin(), estimate->unobservable.end(), "gain_1"),
            estimate->unobservable.end());
}

TEST(ArmCalibration, HeldOutErrorByRegionIsNotFarAboveTheNoise) {
  Laboratory lab(7);
  const auto means = held_out_by_region(lab.record(80, 2e-4), lab.model, {.free = kGainsOffsetsTip});
  ASSERT_TRUE(means.has_value()) << means.error().message;
  ASSERT_EQ(means->means.size(), 8u);
  for (double mean : means->means) {
    EXPECT_GT(mean, 1e-4);  // mean length of the noise alone: 0.32 mm
    EXPECT_LT(mean, 1e-3);
  }
}

// A real arm measured by a laser tracker; bars from an independent program
// (data/ur5_laser_tracker/ORIGIN.md).
class RealArm : public testing::Test {
 protected:
  void SetUp() override {
    auto read_model = device::read_arm_model((folder / "ur5.toml").string());
    auto grid = device::read_arm_samples(folder / "3D_UR5_uncalibrated_grid_cleaned.csv");
    auto random = device::read_arm_samples(folder / "3D_UR5_uncalibrated_random_cleaned.csv");
    ASSERT_TRUE(read_model && grid && random);
    model = *read_model;
    training = grid->observations;
    test = random->observations;
  }
  double held_out_mm(const ArmOptions& options) {
    const auto estimate = calibrate_arm(training, model, options);
    EXPECT_TRUE(estimate.has_value()) << estimate.error().message;
    if (!estimate) return 1e3;
    unobservable = estimate->unobservable;
    return 1e3 * mean_norm(arm_errors(estimate->value, test));
  }
  const std::filesystem::path folder = std::filesystem::path(PALPATE_DATA_DIR) / "ur5_laser_tracker";
  device::ArmModel model;
  std::vector<device::ArmObservation> training, test;
  std::vector<std::string> unobservable;
};

TEST_F(RealArm, BasePoseAloneAgreesWithTheReference) {
  const auto arm = uncorrected_arm(training, model);
  ASSERT_TRUE(arm.has_value()) << arm.error().message;
  EXPECT_NEAR(1e3 * mean_norm(arm->residuals), 0.6252, 0.002);
  EXPECT_NEAR(1e3 * mean_norm(arm_errors(arm->value, test)), 0.4872, 0.002);
}

TEST_F(RealArm, GainsAndOffsetsPredictUnseenPoses) {
  EXPECT_LE(held_out_mm({.free = {.lengths = false}}), 0.30);
  EXPECT_FALSE(unobservable.empty());  // joint 1 turns with the base, joint 6 with the tool
}

TEST_F(RealArm, AllKinematicParametersPredictUnseenPosesToATenthOfAMillimetre) {
  EXPECT_LE(held_out_mm({.free = {.dh = true}}), 0.100);
}

TEST(ArmCalibration, AnArmThatStandsStillOrMovesAlongALineIsRefused) {
  Laboratory lab(5);
  for (const double turn : {0.0, 0.3}) {
    auto samples = lab.record(1, 0.0, false);
    for (int i = 1; i < 12; ++i) {
      samples.push_back(samples.front());
      samples.back().joints[2] = 1e-3 * turn * i;  // a few mm of nearly straight arc
      samples.back().tip = predict_tip(lab.truth, samples.back().joints);
    }
    samples.erase(samples.begin());
    for (const auto method :
         {ArmMethod::one_pass, ArmMethod::alternating, ArmMethod::eq7, ArmMethod::joint}) {
      const auto estimate = calibrate_arm(samples, lab.model, {.method = method});
      ASSERT_FALSE(estimate.has_value());
      EXPECT_NE(estimate.error().message.find("along one line only"), std::string::npos)
          << estimate.error().message;
    }
  }
}

}  // namespace
}  // namespace palpate::calibration
