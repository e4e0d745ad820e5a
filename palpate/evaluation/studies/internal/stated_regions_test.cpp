#include "palpate/evaluation/studies/internal/stated_regions.h"

#include <gtest/gtest.h>

#include <cmath>

#include "palpate/calibration/arm_prediction.h"
#include "palpate/evaluation/studies/internal/arm_methods.h"
#include "palpate/math/random_vector.h"
#include "tests/chi_square.h"

namespace palpate::evaluation::studies {
namespace {

TEST(StatedRegions, NinetyFivePercentOfNormalErrorsAreInside) {
  Random random(1, "test");
  Matrix3 L;
  L << 2.0, 0.0, 0.0, 0.5, 1.0, 0.0, -0.3, 0.2, 0.1;
  L *= 1e-4;
  const Matrix3 C = L * L.transpose();
  int inside = 0;
  constexpr int kDraws = 20000;
  for (int i = 0; i < kDraws; ++i) inside += inside_region(L * normal3(random), C);
  EXPECT_TRUE(tests::is_binomial(inside, kDraws, 0.95));
}

Expected<Estimate<calibration::ArmSolution>> an_estimate(const ArmLaboratory& laboratory, Lengths lengths) {
  return solve_as(kJoint, laboratory.samples, nominal_model(sim::config::reference_world()),
                  laboratory.pivot_tip, {.lengths = lengths, .full_covariance = true});
}

// Scaled covariances must move the shares to all and to none.
TEST(StatedRegions, GrowAndShrinkWithTheStatedCovariance) {
  LaboratorySettings settings;
  settings.samples = 40;
  settings.unused = 0;
  settings.swing = 50;
  const auto laboratory = record_laboratory(white_world(sim::config::reference_world()), 3, settings);
  ASSERT_TRUE(laboratory) << laboratory.error().message;
  auto estimate = an_estimate(*laboratory, Lengths::held);
  ASSERT_TRUE(estimate) << estimate.error().message;
  const Eigen::MatrixXd C = estimate->covariance;
  estimate->covariance = 1e4 * C;
  EXPECT_EQ(share_of_places_inside(*estimate, *laboratory), 1.0);
  EXPECT_TRUE(tip_inside(*estimate, laboratory->truth.tip_in_marker));
  estimate->covariance = 1e-6 * C;
  EXPECT_EQ(share_of_places_inside(*estimate, *laboratory), 0.0);
  EXPECT_FALSE(tip_inside(*estimate, laboratory->truth.tip_in_marker));
}

// The regions' covariance comes from the bound's derivatives; the calibration has its own.
TEST(StatedRegions, OfThePredictedTipAreThoseOfTheCalibration) {
  LaboratorySettings settings;
  settings.samples = 40;
  settings.unused = 0;
  settings.swing = 50;
  const auto laboratory = record_laboratory(sim::config::reference_world(), 5, settings);
  ASSERT_TRUE(laboratory);
  const auto estimate = an_estimate(*laboratory, Lengths::held);
  ASSERT_TRUE(estimate);
  double inside = 0.0;
  for (std::size_t i = 0; i < laboratory->judged.size(); ++i)
    inside += inside_region(
        calibration::predict_tip(estimate->value, laboratory->judged[i]).m - laboratory->judged_place[i],
        calibration::predicted_covariance(*estimate, laboratory->judged[i]));
  EXPECT_GT(inside, 0.0);
  EXPECT_DOUBLE_EQ(share_of_places_inside(*estimate, *laboratory),
                   inside / static_cast<double>(laboratory->judged.size()));
}

TEST(StatedRegions, OtherParametersAreWrongUse) {
  LaboratorySettings settings;
  settings.samples = 40;
  settings.unused = 0;
  settings.swing = 50;
  const auto laboratory = record_laboratory(sim::config::reference_world(), 3, settings);
  ASSERT_TRUE(laboratory);
  const auto estimate = an_estimate(*laboratory, Lengths::free);
  ASSERT_TRUE(estimate);
  EXPECT_THROW(share_of_places_inside(*estimate, *laboratory), std::invalid_argument);
}

}  // namespace
}  // namespace palpate::evaluation::studies
