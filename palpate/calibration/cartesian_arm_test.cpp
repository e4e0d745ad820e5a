// Calibration of an arm that states its place: against a delta arm that is not as its maker has it, and by statistics.
#include <gtest/gtest.h>

#include <Eigen/LU>
#include <array>
#include <cmath>
#include <numbers>

#include "palpate/calibration/arm.h"
#include "palpate/calibration/arm_prediction.h"
#include "palpate/calibration/arm_validation.h"
#include "palpate/math/random_vector.h"
#include "tests/chi_square.h"

namespace palpate::calibration {
namespace {

// Three arms of length `upper` on a base, three rods of length `lower` to a plate that stays level. The geometry of
// Clavel (1988): the elbow of chain i lies at base + upper cos, upper sin in its plane, and the plate's joint a rod away.
struct Delta {
  struct Chain {
    double azimuth, offset /* base's radius less the plate's */, upper, lower, zero /* rad */;
  };
  std::array<Chain, 3> chains;

  static Delta as_made() {
    Delta delta;
    for (std::size_t i = 0; i < 3; ++i)
      delta.chains[i] = {2.0 * std::numbers::pi * static_cast<double>(i) / 3.0, 0.03, 0.11, 0.20, 0.0};
    return delta;
  }
  // As machined and assembled: tenths of a millimetre and of a degree.
  static Delta as_built(Random& random) {
    Delta delta = as_made();
    for (auto& chain : delta.chains) {
      chain.azimuth += random.normal(0.005);
      chain.offset += random.normal(3e-4);
      chain.upper += random.normal(2e-4);
      chain.lower += random.normal(3e-4);
      chain.zero += random.normal(0.008);
    }
    return delta;
  }

  Vector3 elbow(const Chain& chain, double angle) const {
    const Vector3 out(std::cos(chain.azimuth), std::sin(chain.azimuth), 0.0);
    return out * (chain.offset + chain.upper * std::cos(angle)) +
           Vector3(0, 0, chain.upper * std::sin(angle));
  }
  // What the encoders read with the plate at p.
  Vector3 readings(const Vector3& p) const {
    Vector3 psi;
    for (std::size_t i = 0; i < 3; ++i) {
      const Chain& chain = chains[i];
      const Vector3 out(std::cos(chain.azimuth), std::sin(chain.azimuth), 0.0);
      const double x = p.dot(out) - chain.offset, beside = p.dot(Vector3::UnitZ().cross(out)), z = p.z();
      // |(upper cos a - x, beside, upper sin a - z)| = lower, the elbow outwards.
      const double c =
          (x * x + beside * beside + z * z + chain.upper * chain.upper - chain.lower * chain.lower) /
          (2.0 * chain.upper * std::hypot(x, z));
      psi[static_cast<Eigen::Index>(i)] = std::atan2(z, x) - std::acos(c) - chain.zero;
    }
    return psi;
  }
  // Where the plate is, by these readings: Newton's method.
  Vector3 place(const Vector3& psi, Vector3 p) const {
    for (int step = 0; step < 20; ++step) {
      Vector3 r;
      Matrix3 J;
      for (std::size_t i = 0; i < 3; ++i) {
        const auto row = static_cast<Eigen::Index>(i);
        const Vector3 rod = p - elbow(chains[i], psi[row] + chains[i].zero);
        r[row] = rod.squaredNorm() - chains[i].lower * chains[i].lower;
        J.row(row) = 2.0 * rod.transpose();
      }
      p -= J.inverse() * r;
    }
    return p;
  }
};

const Vector3 kMiddle(0.0, 0.0, 0.17);

// A delta arm that states by its maker's lengths where it is, a marker on its handle, and a tracker.
struct DeltaLaboratory {
  explicit DeltaLaboratory(std::uint64_t seed)
      : random(seed, "cartesian arm test"), built(Delta::as_built(random)) {
    model.kind = device::ArmModel::Kind::cartesian;
    model.name = "delta";
    model.places = {{{-0.07, 0.07}, {-0.07, 0.07}, {0.125, 0.215}}};
    model.correction.centre = kMiddle;
    model.correction.reach = 0.07;
  }
  Vector3 somewhere(Random& of) const {
    return kMiddle + Vector3(of.uniform(-0.07, 0.07), of.uniform(-0.07, 0.07), of.uniform(-0.045, 0.045));
  }
  Vector3 stated(const Vector3& true_place) const {
    return made.place(built.readings(true_place), true_place);
  }

  std::vector<device::ArmObservation> record(int count, double noise, bool markers = true) {
    std::vector<device::ArmObservation> samples;
    for (int i = 0; i < count; ++i) {
      const Vector3 place = somewhere(random), tip = X_world_base * place;
      device::ArmObservation sample;
      sample.joints = stated(place);
      const Quaternion turn = X_world_base.rotation * so3_exp(normal3(random, 0.4));
      if (markers)
        sample.marker = Pose<World, TipMarker>{turn, tip - turn * tip_in_marker + normal3(random, noise)};
      else
        sample.tip = Point<World>{tip + normal3(random, noise)};
      samples.push_back(sample);
    }
    return samples;
  }

  // Over places not used otherwise, m.
  double error_to_truth(const ArmSolution& arm, double* worst = nullptr) const {
    Random other(99, "cartesian arm places");
    double sum = 0.0;
    for (int i = 0; i < 500; ++i) {
      const Vector3 place = somewhere(other);
      const Vector3 tip = X_world_base.rotation * place + X_world_base.translation;
      const double error = (predict_tip(arm, stated(place)).m - tip).norm();
      sum += error / 500;
      if (worst != nullptr) *worst = std::max(*worst, error);
    }
    return sum;
  }

  struct Base {
    Quaternion rotation = rotation_from_xyz(Vector3(0.03, -0.07, 0.4));
    Vector3 translation{0.1, -0.4, 0.75};
    Vector3 operator*(const Vector3& p) const { return rotation * p + translation; }
  };
  Random random;
  Delta made = Delta::as_made(), built;
  Base X_world_base;
  Vector3 tip_in_marker{0.004, -0.018, -0.118};
  device::ArmModel model;
};

TEST(CartesianCalibration, ADeltaArmThatIsNotAsMadeIsKnownToTenthsOfAMillimetre) {
  double before = 0.0, after = 0.0, worst = 0.0;
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    DeltaLaboratory lab(seed);
    const auto samples = lab.record(120, 5e-5);
    const auto as_made = uncorrected_arm(samples, lab.model);
    const auto estimate = calibrate_arm(samples, lab.model);
    ASSERT_TRUE(as_made.has_value() && estimate.has_value()) << estimate.error().message;
    EXPECT_EQ(estimate->value.parameters.size(), 6u + 3u + 24u);
    EXPECT_TRUE(estimate->unobservable.empty()) << estimate->unobservable.front();
    EXPECT_EQ(estimate->value.gain, Eigen::VectorXd::Ones(3));
    before = std::max(before, lab.error_to_truth(as_made->value));
    after = std::max(after, lab.error_to_truth(estimate->value, &worst));
    EXPECT_LT((estimate->value.tip_in_marker - lab.tip_in_marker).norm(), 1e-4);
  }
  EXPECT_GT(before, 3e-4) << "there was something to correct";
  EXPECT_LT(after, 1e-4);
  EXPECT_LT(worst, 2.5e-4);
}

TEST(CartesianCalibration, MeasuredTipsDoInPlaceOfMarkers) {
  DeltaLaboratory lab(20);
  const auto estimate = calibrate_arm(lab.record(120, 5e-5, false), lab.model);
  ASSERT_TRUE(estimate.has_value()) << estimate.error().message;
  EXPECT_EQ(estimate->value.parameters.size(), 30u);
  EXPECT_LT(lab.error_to_truth(estimate->value), 1e-4);
}

TEST(CartesianCalibration, AGrossErrorIsLeftOut) {
  DeltaLaboratory lab(21);
  auto samples = lab.record(120, 5e-5);
  samples[7].joints[1] += 0.02;
  samples[31].marker->translation.x() += 0.05;
  const auto estimate = calibrate_arm(samples, lab.model);
  ASSERT_TRUE(estimate.has_value()) << estimate.error().message;
  EXPECT_FALSE(estimate->inlier[7]);
  EXPECT_FALSE(estimate->inlier[31]);
  EXPECT_LT(lab.error_to_truth(estimate->value), 1e-4);
}

// Regions that were not seen tell whether the correction is worth having.
TEST(CartesianCalibration, TheCorrectionIsChosenWhereItHelps) {
  DeltaLaboratory lab(22);
  const auto samples = lab.record(160, 5e-5);
  const auto choice = choose_free(samples, lab.model, {});
  ASSERT_TRUE(choice.has_value()) << choice.error().message;
  EXPECT_TRUE(choice->free.correction);
  EXPECT_EQ(free_text(choice->free, lab.model), "tip,correction");
  lab.built = lab.made;
  const auto none = choose_free(lab.record(160, 5e-5), lab.model, {});
  ASSERT_TRUE(none.has_value()) << none.error().message;
  EXPECT_FALSE(none->free.correction) << none->why;
}

TEST(CartesianCalibration, WhatCannotBeKnownIsRefusedOrNamed) {
  DeltaLaboratory lab(23);
  const auto few = calibrate_arm(lab.record(9, 5e-5), lab.model);
  ASSERT_FALSE(few.has_value());
  EXPECT_NE(few.error().message.find("9 samples for 33 unknowns"), std::string::npos) << few.error().message;
  const auto paper = calibrate_arm(lab.record(60, 5e-5), lab.model, {.method = ArmMethod::alternating});
  ASSERT_FALSE(paper.has_value());
  EXPECT_NE(paper.error().message.find("use the joint method"), std::string::npos);
  // All in a plane: what bends across it is nobody's to know.
  auto flat = lab.record(200, 5e-5);
  std::vector<device::ArmObservation> in_plane;
  for (const auto& sample : flat)
    if (std::abs(sample.joints[2] - kMiddle.z()) < 0.003) in_plane.push_back(sample);
  ASSERT_GT(in_plane.size(), 11u);
  const auto estimate = calibrate_arm(in_plane, lab.model);
  if (estimate) {
    EXPECT_FALSE(estimate->unobservable.empty());
  }
}

// The truth is such a polynomial, the noise is known: squared errors in units of the covariance.
TEST(CartesianCalibrationStatistics, ErrorsAgreeWithTheCovariance) {
  constexpr int kDeltas = 150;
  double sum = 0.0;
  for (std::uint64_t seed = 0; seed < kDeltas; ++seed) {
    DeltaLaboratory lab(300 + seed);
    ArmSolution truth;
    truth.model = lab.model;
    for (double& term : truth.model.correction.terms) term = lab.random.normal(5e-4);
    truth.gain = Eigen::VectorXd::Ones(3), truth.offset = Eigen::VectorXd::Zero(3);
    truth.X_world_base = {lab.X_world_base.rotation, lab.X_world_base.translation};
    std::vector<device::ArmObservation> samples;
    for (int i = 0; i < 80; ++i) {
      device::ArmObservation sample;
      sample.joints = lab.somewhere(lab.random);
      sample.tip = Point<World>{predict_tip(truth, sample.joints).m + normal3(lab.random, 2e-4)};
      sample.covariance = 4e-8 * Matrix3::Identity();
      sample.systematic = 0.0;
      samples.push_back(sample);
    }
    const auto estimate = calibrate_arm(samples, lab.model);
    ASSERT_TRUE(estimate.has_value()) << estimate.error().message;
    const Vector3 at = kMiddle + 0.05 * Vector3::Unit(static_cast<Eigen::Index>(seed % 3));
    const Vector3 error = predict_tip(estimate->value, at).m - predict_tip(truth, at).m;
    sum += tests::normalised_square(Eigen::VectorXd(error), predicted_covariance(*estimate, at));
  }
  EXPECT_TRUE(tests::is_chi_square(sum, 3 * kDeltas)) << sum / (3 * kDeltas);
}

}  // namespace
}  // namespace palpate::calibration
