#include "palpate/evaluation/studies/internal/cramer_rao.h"

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <cmath>

#include "palpate/evaluation/studies/internal/arm_laboratory.h"
#include "palpate/math/random_vector.h"
#include "tests/chi_square.h"

namespace palpate::evaluation::studies {
namespace {

TrueArm an_arm() {
  return {{0.21, 0.20},
          {{1.01, 0.985, 1.02}, {0.02, -0.015, 0.01}},
          {so3_exp({0.1, -0.2, 0.3}), {0.1, -1.4, 1.75}}};
}

Vector3 readings(Random& random) {
  return {random.uniform(-0.7, 0.7), random.uniform(0.0, 1.2), random.uniform(-0.4, 1.0)};
}

// Where prediction and measurement differ, as a function of the fourteen numbers; the measured marker stands
// still at the origin.
Vector3 difference(const TrueArm& arm, const Eigen::Matrix<double, kBoundSize, 1>& x, const Vector3& psi,
                   const Quaternion& marker) {
  device::JointCorrection joints = arm.joints;
  joints.gain += x.segment<3>(kBoundGains);
  joints.offset.tail<2>() += x.segment<2>(kBoundOffsets);
  const Quaternion turn = so3_exp(x.head<3>());
  return turn * (arm.X_world_base.rotation * device::phantom_tip(joints.apply(psi), arm.lengths).m) +
         arm.X_world_base.translation + x.segment<3>(3) - marker * Vector3(x.tail<3>());
}

TEST(CramerRao, DerivativesAreThoseOfFiniteDifferences) {
  const auto arm = an_arm();
  Random random(3, "test");
  for (int trial = 0; trial < 5; ++trial) {
    const Vector3 psi = readings(random);
    const Quaternion marker = so3_exp(normal3(random));
    const auto J = tip_derivatives(arm, psi, marker);
    for (Eigen::Index k = 0; k < kBoundSize; ++k) {
      constexpr double kStep = 1e-5;
      Eigen::Matrix<double, kBoundSize, 1> x = Eigen::Matrix<double, kBoundSize, 1>::Zero();
      x[k] = kStep;
      const Vector3 up = difference(arm, x, psi, marker);
      x[k] = -kStep;
      const Vector3 slope = (up - difference(arm, x, psi, marker)) / (2.0 * kStep);
      EXPECT_LT((slope - J.col(k)).norm(), 1e-9) << k;  // step^2 times a third derivative below 1
    }
  }
}

// With the joints known only the base is free, and the expected error at a place is in closed form
// (Fitzpatrick, West, Maurer 1998, equation 46): s^2 / N (1 + sum of d_k^2 / f_k^2 / 3), s the 3-D rms error
// of a point, d_k the place's and f_k the points' rms distance from principal axis k. That form is of first
// order and holds for errors alike in all directions.
TEST(CramerRao, TheBasesPartIsTheClosedFormOfRigidRegistration) {
  const auto arm = an_arm();
  Random random(5, "test");
  constexpr double kSigma = 0.1e-3;
  constexpr int kPoints = 40;
  std::vector<Vector3> places;
  Matrix6 information = Matrix6::Zero();
  for (int i = 0; i < kPoints; ++i) {
    const Vector3 psi = readings(random);
    const Eigen::Matrix<double, 3, 6> J = tip_derivatives(arm, psi, Quaternion::Identity()).leftCols<6>();
    information += J.transpose() * J / (kSigma * kSigma);
    places.push_back(arm.X_world_base.rotation * device::phantom_tip(arm.joints.apply(psi), arm.lengths).m);
  }
  const Matrix6 C = information.inverse();
  Vector3 mean = Vector3::Zero();
  for (const auto& p : places) mean += p / kPoints;
  Matrix3 spread = Matrix3::Zero();
  for (const auto& p : places) spread += (p - mean) * (p - mean).transpose() / kPoints;
  const Eigen::SelfAdjointEigenSolver<Matrix3> axes(spread);
  const Vector3 target = readings(random);
  const Eigen::Matrix<double, 3, 6> J = tip_derivatives(arm, target, Quaternion::Identity()).leftCols<6>();
  const Vector3 d =
      axes.eigenvectors().transpose() *
      (arm.X_world_base.rotation * device::phantom_tip(arm.joints.apply(target), arm.lengths).m - mean);
  double sum = 0.0;
  for (int k = 0; k < 3; ++k) {
    const double d2 = d.squaredNorm() - d[k] * d[k];
    const double f2 = axes.eigenvalues().sum() - axes.eigenvalues()[k];
    sum += d2 / f2 / 3.0;
  }
  const double closed_form = 3.0 * kSigma * kSigma / kPoints * (1.0 + sum);
  EXPECT_NEAR((J * C * J.transpose()).trace(), closed_form, 1e-9 * closed_form);
}

std::vector<BoundSample> some_samples(int count) {
  Random random(7, "test");
  std::vector<BoundSample> samples;
  for (int i = 0; i < count; ++i)
    samples.push_back(
        {readings(random), so3_exp(0.5 * normal3(random)), Matrix3::Identity() * (0.2e-3 * 0.2e-3)});
  return samples;
}

TEST(CramerRao, TwiceTheSamplesHalveTheCovarianceAndAnUnknownTipCosts) {
  const auto arm = an_arm();
  const auto once = some_samples(30);
  auto twice = once;
  twice.insert(twice.end(), once.begin(), once.end());
  const auto known = parameter_bound(arm, once, TipIs::known);
  const auto estimated = parameter_bound(arm, once, TipIs::estimated);
  EXPECT_LT((parameter_bound(arm, twice, TipIs::known) - 0.5 * known).norm(), 1e-9 * known.norm());
  std::vector<Vector3> psi;
  for (const auto& s : once) psi.push_back(s.psi);
  EXPECT_GT(workspace_bound(arm, estimated, psi), workspace_bound(arm, known, psi));
}

TEST(CramerRao, TooFewSamplesHaveNoBound) {
  EXPECT_FALSE(parameter_bound(an_arm(), some_samples(3), TipIs::known).allFinite());
  EXPECT_FALSE(parameter_bound(an_arm(), {}, TipIs::estimated).allFinite());
}

// Independent of the derivatives: many recordings, one solve each, scatter about the truth. Some eleven directions share
// the error, unequally: as many as five or six that share it alike.
TEST(CramerRao, TheJointMethodsErrorsInAWhiteWorldReachTheBound) {
  auto world = white_world(sim::config::reference_world());
  double ours = 0.0, bound = 0.0;
  constexpr int kRecordings = 60;
  for (std::uint64_t seed = 1; seed <= kRecordings; ++seed) {
    LaboratorySettings settings;
    settings.samples = 40;
    settings.unused = 0;
    settings.swing = 50;
    const auto laboratory = record_laboratory(world, seed, settings);
    ASSERT_TRUE(laboratory) << laboratory.error().message;
    calibration::ArmOptions options;
    options.free.lengths = false;
    options.tip = laboratory->pivot_tip;
    const auto estimate = calibration::calibrate_arm(laboratory->samples, nominal_model(world), options);
    ASSERT_TRUE(estimate) << estimate.error().message;
    for (const double e : errors_to_truth(estimate->value, *laboratory))
      ours += e * e / static_cast<double>(laboratory->judged.size());
    const auto C = parameter_bound(laboratory->arm(), bound_samples(laboratory->samples), TipIs::estimated);
    bound += std::pow(workspace_bound(laboratory->arm(), C, laboratory->judged), 2);
  }
  EXPECT_TRUE(tests::is_chi_square(5.5 * kRecordings * ours / bound, 5.5 * kRecordings));
}

}  // namespace
}  // namespace palpate::evaluation::studies
