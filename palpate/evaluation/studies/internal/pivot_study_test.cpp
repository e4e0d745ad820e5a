#include "palpate/evaluation/studies/internal/pivot_study.h"

#include <gtest/gtest.h>

#include <cmath>

#include "palpate/core/units.h"
#include "palpate/evaluation/studies/study.h"

namespace palpate::evaluation::studies {
namespace {

double rms_error(const SwingSettings& settings, const SwingErrors& errors, calibration::PivotMethod method,
                 bool centre, int runs, bool with_motion = false) {
  const auto& world = sim::config::reference_world();
  double sum = 0.0;
  for (int run = 0; run < runs; ++run) {
    calibration::PivotCalibrationOptions options;
    options.method = method;
    options.with_motion = with_motion;
    const auto estimate = calibration::calibrate_pivot(
        SwingDraw(world, settings, static_cast<std::uint64_t>(run)).with(errors).poses, options);
    if (!estimate) throw std::runtime_error(estimate.error().message);
    sum += centre ? estimate->value.segments[0].pivot.squaredNorm()
                  : (estimate->value.tip - world.tip_marker.tip).squaredNorm();
  }
  return std::sqrt(sum / runs);
}

// Uniform orientations have mean zero, so centre and tip separate and each is a mean of n displacements: rms
// x / sqrt(n). The sphere fit sees only the part of each along the radius, the normal matrix is n/3: rms
// sqrt(3) x / sqrt(n). 300 runs of three components determine an rms to 1 / sqrt(1800) = 2.4 %; 8 % adds what
// is of higher order in 1/n.
TEST(PivotStudy, ARandomlyMovingTipOnAFullSphereIsTheClosedForm) {
  const SwingSettings settings;
  const SwingErrors errors{0.0, 1e-3};
  const double expected = errors.tip_rms / std::sqrt(static_cast<double>(settings.poses));
  EXPECT_NEAR(rms_error(settings, errors, calibration::PivotMethod::algebraic, true, 300) / expected, 1.0,
              0.08);
  EXPECT_NEAR(rms_error(settings, errors, calibration::PivotMethod::algebraic, false, 300) / expected, 1.0,
              0.08);
  EXPECT_NEAR(rms_error(settings, errors, calibration::PivotMethod::sphere, true, 300) / expected,
              std::sqrt(3.0), 0.14);
}

TEST(PivotStudy, AQuarterOfTheSphereIsHarder) {
  SwingSettings settings;
  const SwingErrors errors{0.2e-3, 0.0};
  const double full = rms_error(settings, errors, calibration::PivotMethod::sphere, true, 40);
  settings.coverage = Coverage::quarter_sphere;
  EXPECT_GT(rms_error(settings, errors, calibration::PivotMethod::sphere, true, 40), 2.0 * full);
}

// A displacement along the stylus is the same in the marker's frame in every pose: its mean goes into the
// tip.
TEST(PivotStudy, ADraggedTipIsOffByTheMeanPullUnlessTheArmsReadingIsUsed) {
  SwingSettings settings;
  settings.coverage = Coverage::quarter_sphere;
  settings.motion = TipMotion::dragged;
  const SwingErrors errors{0.0, 1e-3};
  const double mean_pull = errors.tip_rms / std::sqrt(13.0 / 12.0);
  EXPECT_NEAR(rms_error(settings, errors, calibration::PivotMethod::algebraic, false, 40), mean_pull,
              0.1 * mean_pull);
  EXPECT_LT(rms_error(settings, errors, calibration::PivotMethod::algebraic, false, 40, true),
            0.1 * mean_pull);
}

// The pivot is then the mean place of the tip, not the place it is held at.
TEST(PivotStudy, WithTheArmsReadingTheCentreIsTheMeanPlaceOfTheTip) {
  SwingSettings settings;
  settings.coverage = Coverage::quarter_sphere;
  settings.motion = TipMotion::dragged;
  const auto swung = SwingDraw(sim::config::reference_world(), settings, 1).with({0.0, 2e-3});
  calibration::PivotCalibrationOptions options;
  options.with_motion = true;
  const auto estimate = calibration::calibrate_pivot(swung.poses, options);
  ASSERT_TRUE(estimate) << estimate.error().message;
  EXPECT_GT(swung.mean_place.norm(), 1e-3);
  EXPECT_LT((estimate->value.segments[0].pivot - swung.mean_place).norm(), 0.1e-3);
}

TEST(PivotStudy, LedErrorsHaveTheSizeTheyAreSaidToHave) {
  // A marker's place is the mean of six LEDs where the errors are white: rms x / sqrt(6).
  constexpr double kLedRms = 0.5e-3;
  double sum = 0.0;
  const auto& world = sim::config::reference_world();
  Vector3 middle = Vector3::Zero();
  for (const auto& led : world.tip_marker.leds)
    middle += led / static_cast<double>(world.tip_marker.leds.size());
  constexpr int kRuns = 20;
  for (std::uint64_t seed = 0; seed < kRuns; ++seed) {
    const SwingDraw draw(world, {}, seed);
    const auto a = draw.with({}).poses, b = draw.with({kLedRms, 0.0}).poses;
    for (std::size_t i = 0; i < a.size(); ++i)
      sum += (b[i].rotation * middle + b[i].translation - a[i].rotation * middle - a[i].translation)
                 .squaredNorm() /
             static_cast<double>(a.size() * kRuns);
  }
  EXPECT_NEAR(std::sqrt(sum), kLedRms / std::sqrt(6.0), 0.04 * kLedRms / std::sqrt(6.0));
}

TEST(PivotStudy, WithoutNoiseThereIsNoErrorAndMoreNoiseMeansMore) {
  StudyOptions options;
  options.runs = 4;
  const auto study = study_marker_noise(options);
  ASSERT_TRUE(study) << study.error().message;
  for (const auto& curve : study->curves) {
    EXPECT_LT(curve.points.front().y.mean, 1e-6) << curve.figure << curve.label;
    EXPECT_GT(curve.points.back().y.mean, curve.points[2].y.mean) << curve.figure << curve.label;
    EXPECT_EQ(curve.points.back().y.runs, 4);
  }
}

}  // namespace
}  // namespace palpate::evaluation::studies
