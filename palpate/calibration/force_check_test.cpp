#include "palpate/calibration/force_check.h"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <cmath>
#include <map>
#include <numbers>
#include <string>

#include "palpate/core/random.h"
#include "palpate/device/phantom.h"
#include "palpate/math/linear_algebra.h"

namespace palpate::calibration {
namespace {

// A hand drawn at random, and an arm with motors wired as told. Independent of the estimator: torques by the arm's
// Jacobian, a spring per pose.
struct Trial {
  Matrix3 axes = Matrix3::Identity();              // of the command, before it becomes torques
  Matrix3 motors = Matrix3::Identity();            // torques given over torques commanded
  double anisotropy = 0.35;                        // of the logarithm of the hand's stiffness, per component
  double change = 0.1, grip = 0.25, noise = 0.08;  // noise: of the response, per ramp and component
  double compliance = 1.0 / 250.0;
  bool states_place = false;  // a delta's axes, a little off those of ArmBase, in place of joints
  Vector3 device_turn = {0.02, -0.03, 0.05};
  std::vector<Vector3> angles = {
      {0.0, 0.2, 0.1}, {-0.5, 0.5, 0.1}, {0.5, 0.4, -0.2}, {-0.5, 0.0, -0.3}, {0.5, 0.1, 0.3}};

  static Matrix3 random_symmetric(Random& random, double sd) {
    Matrix3 E;
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j <= i; ++j) E(i, j) = E(j, i) = random.normal(i == j ? sd : sd / std::sqrt(2.0));
    return E;
  }
  static Matrix3 exponential(const Matrix3& E) {
    const auto eigen = symmetric_eigen(E);
    return eigen.vectors * Eigen::VectorXd(eigen.values.array().exp()).asDiagonal() *
           eigen.vectors.transpose();
  }

  std::vector<ForcePose> play(std::uint64_t seed) const {
    Random random(seed, "force check");
    const Matrix3 hand = random_symmetric(random, anisotropy);
    std::vector<ForcePose> poses;
    for (const auto& theta : angles) {
      const Matrix3 J =
          states_place ? so3_exp(device_turn).toRotationMatrix() : device::phantom_jacobian(theta);
      const double firm = random.normal(grip);
      const Matrix3 C =
          compliance * exponential(hand + random_symmetric(random, change) + firm * Matrix3::Identity());
      const Matrix3 A = C * J.transpose().inverse() * motors * J.transpose() * axes;
      ForcePose pose{J, {}};
      for (int repeat = 0; repeat < 1; ++repeat)
        for (int axis = 0; axis < 3; ++axis)
          for (const double sign : {1.0, -1.0}) {
            const Vector3 u = sign * Vector3::Unit(axis);
            Vector3 response = A * u;
            for (auto& component : response) component += random.normal(noise * compliance);
            pose.ramps.push_back({u, response});
          }
      poses.push_back(pose);
    }
    return poses;
  }
  ForceCheck check(std::uint64_t seed) const {
    ForceCheckSettings settings;
    settings.states_place = states_place;
    const auto found = check_forces(play(seed), settings);
    EXPECT_TRUE(found) << (found ? "" : found.error().message);
    return found.value_or(ForceCheck{});
  }
  std::map<ForceVerdict, int> verdicts(int seeds) const {
    std::map<ForceVerdict, int> counted;
    for (int seed = 1; seed <= seeds; ++seed) ++counted[check(static_cast<std::uint64_t>(seed)).verdict];
    return counted;
  }
};

Matrix3 exchanged(int i, int j) {
  Matrix3 P = Matrix3::Identity();
  P.col(i).swap(P.col(j));
  return P;
}
Matrix3 with_gain(int i, double gain) {
  Matrix3 S = Matrix3::Identity();
  S(i, i) = gain;
  return S;
}

TEST(ForceCheck, AHealthyArmAgreesWithHandsThatGiveWayAlikeOrNot) {
  for (const double anisotropy : {0.0, 0.35, 0.5}) {
    Trial trial;
    trial.anisotropy = anisotropy;
    const ForceCheck check = trial.check(1);
    EXPECT_EQ(check.verdict, ForceVerdict::agreed) << anisotropy << ": " << check.words;
    EXPECT_GT(check.compliance, 0.2 * trial.compliance);
    EXPECT_LT(check.compliance, 5.0 * trial.compliance);
    for (int i = 0; i < 3; ++i)
      EXPECT_LT(std::abs(check.joint_gains[i] - 1.0), 3.0 * std::sqrt(check.covariance(i, i)) + 0.15);
    EXPECT_LT((check.map - Matrix3::Identity()).norm(), 0.5);
  }
}

TEST(ForceCheck, EachFaultIsRefusedByItsName) {
  for (int i = 0; i < 3; ++i) {
    const int next = (i + 1) % 3;
    const auto found = [](const Matrix3& axes, const Matrix3& motors) {
      Trial trial;
      trial.axes = axes;
      trial.motors = motors;
      return trial.check(3);
    };
    const Matrix3 fine = Matrix3::Identity();
    ForceCheck check = found(with_gain(i, -1.0), fine);
    EXPECT_EQ(check.verdict, ForceVerdict::axis_mirrored) << check.words;
    EXPECT_EQ(check.first, i);
    EXPECT_NE(check.words.find(std::string("axis ") + "xyz"[i]), std::string::npos) << check.words;
    check = found(fine, with_gain(i, -1.0));
    EXPECT_EQ(check.verdict, ForceVerdict::joint_mirrored) << check.words;
    EXPECT_EQ(check.first, i);
    check = found(fine, exchanged(i, next));
    EXPECT_EQ(check.verdict, ForceVerdict::joints_exchanged) << check.words;
    EXPECT_EQ(check.first, std::min(i, next));
    EXPECT_EQ(check.second, std::max(i, next));
    check = found(exchanged(i, next), fine);
    EXPECT_EQ(check.verdict, ForceVerdict::axes_exchanged) << check.words;
    check = found(fine, with_gain(i, 0.0));
    EXPECT_EQ(check.verdict, ForceVerdict::joint_without_power) << check.words;
    EXPECT_EQ(check.first, i);
    for (const double gain : {0.5, 2.0}) {
      check = found(fine, with_gain(i, gain));
      EXPECT_EQ(check.verdict, ForceVerdict::ratio_off) << gain << ": " << check.words;
      EXPECT_TRUE(check.first == i || check.second == i) << gain << ": " << check.words;
    }
  }
}

// Its Jacobian is the same in all poses, so that uneven motors look like an uneven hand: not so a mirrored axis, which
// no hand resembles.
TEST(ForceCheck, OfAnArmThatStatesItsPlaceSignsAndOrderAreToldAndNoRatio) {
  Trial trial;
  trial.states_place = true;
  for (const double anisotropy : {0.0, 0.35, 0.5}) {
    trial.anisotropy = anisotropy;
    const ForceCheck check = trial.check(1);
    EXPECT_EQ(check.verdict, ForceVerdict::agreed) << anisotropy << ": " << check.words;
    EXPECT_FALSE(check.ratios_told);
    EXPECT_NE(check.words.find("along each axis; whether all axes are equally strong"), std::string::npos)
        << check.words;
  }
  for (int i = 0; i < 3; ++i) {
    const int next = (i + 1) % 3;
    trial = {};
    trial.states_place = true;
    trial.motors = with_gain(i, -1.0);
    ForceCheck check;
    for (const double anisotropy : {0.0, 0.35}) {
      trial.anisotropy = anisotropy;
      // An even hand along the axes themselves tells the least of ratios.
      trial.change = anisotropy == 0.0 ? 0.0 : 0.1;
      trial.device_turn = anisotropy * Vector3(0.1, -0.1, 0.2);
      check = trial.check(3);
      EXPECT_EQ(check.verdict, ForceVerdict::axis_mirrored) << anisotropy << ": " << check.words;
      EXPECT_EQ(check.first, i);
    }
    trial.motors = exchanged(i, next);
    check = trial.check(3);
    EXPECT_EQ(check.verdict, ForceVerdict::axes_exchanged) << check.words;
    EXPECT_EQ(check.first, std::min(i, next));
    EXPECT_EQ(check.second, std::max(i, next));
    trial.motors = with_gain(i, 0.0);
    check = trial.check(3);
    EXPECT_EQ(check.verdict, ForceVerdict::joint_without_power) << check.words;
    EXPECT_NE(check.words.find(std::string("axis ") + "xyz"[i]), std::string::npos) << check.words;
    trial.motors = with_gain(i, 5.5);
    trial.anisotropy = trial.change = trial.grip = 0.0;
    trial.noise = 0.02;
    check = trial.check(3);
    EXPECT_EQ(check.verdict, ForceVerdict::ratio_off) << check.words;
  }
  trial = {};
  trial.states_place = true;
  trial.noise = 2.0;
  EXPECT_EQ(trial.check(1).verdict, ForceVerdict::restless_hand);
}

TEST(ForceCheck, AMirroredAxisIsRefusedInTwoPosesToo) {
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    Trial trial;
    trial.angles.resize(2);
    trial.axes = with_gain(1, -1.0);
    EXPECT_NE(trial.check(seed).verdict, ForceVerdict::agreed);
  }
}

// An uneven hand makes a gain's size uncertain, not its sign.
TEST(ForceCheck, AMirroredAxisIsNamedWhateverTheHand) {
  for (std::uint64_t seed = 1; seed <= 8; ++seed)
    for (int i = 0; i < 3; ++i) {
      Trial trial;
      trial.anisotropy = 0.5;
      trial.axes = with_gain(i, -1.0);
      const ForceCheck check = trial.check(seed);
      EXPECT_EQ(check.verdict, ForceVerdict::axis_mirrored) << seed << ": " << check.words;
      EXPECT_EQ(check.first, i);
    }
}

TEST(ForceCheck, WhatCannotBeToldIsRefusedAndSaysWhy) {
  Trial trial;
  trial.compliance = 2e-5;
  EXPECT_EQ(trial.check(1).verdict, ForceVerdict::too_little_motion);
  trial = {};
  trial.motors.setZero();  // no motor has power: only noise
  trial.noise = 0.005;
  EXPECT_EQ(trial.check(1).verdict, ForceVerdict::too_little_motion);
  trial = {};
  trial.noise = 2.0;
  EXPECT_EQ(trial.check(1).verdict, ForceVerdict::restless_hand);
  // In one pose the turret's gain may be the hand's own softness sideways. (Where the hand's axes are oblique, one pose
  // does tell: what a push along x does along y, and the other way round, are alike.)
  trial = {};
  trial.anisotropy = trial.change = 0.0;
  trial.angles.resize(1);
  EXPECT_EQ(trial.check(1).verdict, ForceVerdict::undetermined) << trial.check(1).words;
}

TEST(ForceCheck, RampsThatAreMissingOrNoNumbersAreWrongUse) {
  auto poses = Trial{}.play(1);
  poses[1].ramps.resize(5);
  EXPECT_FALSE(check_forces(poses));
  poses = Trial{}.play(1);
  poses[0].ramps[0].compliance[1] = std::nan("");
  const auto refusal = check_forces(poses);
  ASSERT_FALSE(refusal);
  EXPECT_EQ(refusal.error().exit_code(), 2);
  EXPECT_FALSE(check_forces({}));
  poses = Trial{}.play(1);
  poses[1].jacobian.conservativeResize(3, 6);  // of another arm
  poses[1].jacobian.setOnes();
  EXPECT_FALSE(check_forces(poses));
}

// A hand with mass, damper and drift, moved by a ramp: what is in phase with the force is its compliance.
TEST(RampResponse, IsTheSpringAndNotTheDriftOrTheDamper) {
  constexpr double kStiffness = 250.0, kDamping = 12.0, kMass = 0.2, kStep = 1e-4, kLength = 1.2;
  Vector3 x = Vector3::Zero(), v = Vector3::Zero();
  const Vector3 u = Vector3(1.0, 2.0, -2.0).normalized();
  std::vector<RampSample> samples;
  for (int i = 0; i * kStep < kLength; ++i) {
    const double t = i * kStep, f = 0.25 * (1.0 - std::cos(2.0 * std::numbers::pi * t / kLength));
    v += kStep / kMass * (f * u - kStiffness * x - kDamping * v);
    x += kStep * v;
    if (i % 10 == 0) samples.push_back({t, f, x + Vector3(0.002, -0.001, 0.0) * t});
  }
  const auto response = ramp_response(u, samples);
  ASSERT_TRUE(response);
  // The mass takes m w^2 = 5.5 N/m off the stiffness.
  EXPECT_LT((response->compliance - u / kStiffness).norm(), 0.04 / kStiffness);
  EXPECT_FALSE(ramp_response(u, std::span(samples).first(5)));
  for (auto& sample : samples) sample.force = 0.0;
  EXPECT_FALSE(ramp_response(u, samples));
}

TEST(GainOfWeight, IsTheMiddleOfRisingAndSinkingAndRefusesWhatIsNotShownToBeNearOne) {
  // 80 g, gain 0.9, friction 0.04 N.
  const double weight = 0.0800 * 9.81;
  std::vector<double> rising, sinking;
  Random random(2, "lifts");
  for (int i = 0; i < 4; ++i) {
    rising.push_back((weight + 0.04) / 0.9 + random.normal(0.01));
    sinking.push_back((weight - 0.04) / 0.9 + random.normal(0.01));
  }
  const auto found = gain_of_weight(weight, rising, sinking);
  ASSERT_TRUE(found) << found.error().message;
  EXPECT_NEAR(found->gain, 0.9, 0.02);
  EXPECT_NEAR(found->friction, 0.04, 0.01);
  EXPECT_LT(found->deviation, 0.02);
  for (auto* list : {&rising, &sinking})
    for (auto& force : *list) force *= 0.4;
  const auto refusal = gain_of_weight(weight, rising, sinking);
  ASSERT_FALSE(refusal);
  EXPECT_NE(refusal.error().message.find("a gain of 2.2"), std::string::npos) << refusal.error().message;
  EXPECT_FALSE(gain_of_weight(weight, std::span(rising).first(2), std::span(sinking).first(2)));
}

// How often a healthy arm is refused, and a faulty one accepted, over hands drawn at random. docs/theory/force-check.md
// has the figures.
TEST(ForceCheckStatistics, HealthyArmsAreAcceptedAndFaultyOnesRefused) {
  constexpr int kHands = 100;
  const auto agreed = [](Trial trial) {
    const auto verdicts = trial.verdicts(kHands);
    const auto found = verdicts.find(ForceVerdict::agreed);
    return found == verdicts.end() ? 0 : found->second;
  };
  for (const bool states_place : {false, true})
    for (const double anisotropy : {0.0, 0.35, 0.5}) {
      Trial trial;
      trial.states_place = states_place;
      trial.anisotropy = anisotropy;
      const int accepted = agreed(trial);
      std::printf("healthy%s, anisotropy %.2f: %d of %d accepted\n", states_place ? ", states its place" : "",
                  anisotropy, accepted, kHands);
      EXPECT_GE(accepted, kHands * (states_place && anisotropy > 0.4 ? 90 : 95) / 100);
    }
  int wrongly = 0, tried = 0, weakest = 0;
  for (int i = 0; i < 3; ++i) {
    std::vector<Trial> faults(5);
    faults[0].axes = with_gain(i, -1.0);
    faults[1].motors = with_gain(i, -1.0);
    faults[2].motors = with_gain(i, 0.0);
    faults[3].motors = exchanged(i, (i + 1) % 3);
    faults[4].axes = exchanged(i, (i + 1) % 3);
    for (auto& fault : faults)
      for (const bool states_place : {false, true}) {
        fault.states_place = states_place;
        wrongly += agreed(fault), tried += kHands;
      }
    for (const double gain : {0.5, 2.0}) {
      Trial weak;
      weak.motors = with_gain(i, gain);
      weakest += agreed(weak);
    }
  }
  std::printf("mirrored, exchanged, without power: %d of %d accepted; a gain of half or twice: %d of %d\n",
              wrongly, tried, weakest, 6 * kHands);
  EXPECT_EQ(wrongly, 0);
  EXPECT_LE(weakest, 6 * kHands / 50);
}

}  // namespace
}  // namespace palpate::calibration
