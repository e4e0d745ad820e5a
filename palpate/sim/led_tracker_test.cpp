#include "palpate/sim/led_tracker.h"

#include <gtest/gtest.h>

#include <Eigen/LU>

#include "palpate/core/random.h"
#include "tests/chi_square.h"

namespace palpate::sim {
namespace {

std::vector<LinearCamera> three_cameras() {
  const Vector3 target(0.05, -1.4, 1.75);
  return {LinearCamera::aimed({-0.55, 0, 0}, target, Vector3::UnitX()),
          LinearCamera::aimed({0, 0, 0}, target, Vector3::UnitY()),
          LinearCamera::aimed({0.55, 0, 0}, target, Vector3::UnitX())};
}

const std::vector<Vector3> kBody{{0.06, 0, 0},      {0.03, 0.052, 0.008}, {-0.03, 0.052, 0},
                                 {-0.06, 0, 0.008}, {-0.03, -0.052, 0},   {0.03, -0.052, 0.008}};

std::vector<double> seen_by(const std::vector<LinearCamera>& cameras, const Vector3& p) {
  std::vector<double> u;
  for (const auto& camera : cameras) u.push_back(camera.measure(p));
  return u;
}

TEST(LinearCamera, GradientIsTheFiniteDifference) {
  const Vector3 p(0.1, -1.2, 1.6);
  for (const auto& camera : three_cameras()) {
    const Vector3 gradient = camera.gradient(p);
    for (int i = 0; i < 3; ++i) {
      const Vector3 step = 1e-6 * Vector3::Unit(i);
      // Central differences of a smooth function with second derivative about 1: error about 1e-10.
      EXPECT_NEAR(gradient[i], (camera.measure(p + step) - camera.measure(p - step)) / 2e-6, 1e-8);
    }
  }
}

TEST(Triangulation, PerfectMeasurementsGiveTheVeryPoint) {
  const auto cameras = three_cameras();
  Random random(1);
  for (int i = 0; i < 100; ++i) {
    const Vector3 p(random.uniform(-0.4, 0.4), random.uniform(-1.6, -0.8), random.uniform(0.9, 2.2));
    const auto point = triangulate(cameras, seen_by(cameras, p), 1e-4);
    ASSERT_TRUE(point);
    EXPECT_LT((point->place - p).norm(), 1e-11);
  }
}

TEST(Triangulation, MoreCamerasThanNeededAgreeToo) {
  auto cameras = three_cameras();
  cameras.push_back(LinearCamera::aimed({0, 0.4, 0}, {0.05, -1.4, 1.75}, Vector3::UnitY()));
  const Vector3 p(0.02, -1.3, 1.7);
  const auto point = triangulate(cameras, seen_by(cameras, p), 1e-4);
  ASSERT_TRUE(point);
  EXPECT_LT((point->place - p).norm(), 1e-11);
}

TEST(Triangulation, CovarianceIsThatOfRepeatedNoisyMeasurements) {
  const auto cameras = three_cameras();
  const Vector3 p(0.1, -1.3, 1.6);
  const double sd = 1e-4;
  const auto clean = seen_by(cameras, p);
  const Matrix3 stated = triangulate(cameras, clean, sd)->covariance;
  Random random(7);
  Matrix3 scatter = Matrix3::Zero();
  constexpr int kRuns = 20000;
  for (int i = 0; i < kRuns; ++i) {
    auto u = clean;
    for (auto& x : u) x += random.normal(sd);
    const Vector3 error = triangulate(cameras, u, sd)->place - p;
    scatter += error * error.transpose() / kRuns;
  }
  // A sample variance of 20000 runs has a relative sd of 1 %; 4 sd and a little for the lens' nonlinearity.
  EXPECT_LT((scatter - stated).norm(), 0.05 * stated.norm());
  EXPECT_NEAR(std::sqrt(stated.trace()), sd * triangulation_gain(cameras, p), 1e-12);
}

TEST(Triangulation, RefusesCamerasThatAllMeasureTheSameWay) {
  const Vector3 target(0, 0, 2);
  const std::vector<LinearCamera> cameras{LinearCamera::aimed({-0.5, 0, 0}, target, Vector3::UnitX()),
                                          LinearCamera::aimed({0, 0, 0}, target, Vector3::UnitX()),
                                          LinearCamera::aimed({0.5, 0, 0}, target, Vector3::UnitX())};
  EXPECT_FALSE(triangulate(cameras, seen_by(cameras, {0.1, 0.1, 1.9}), 1e-4));
}

std::vector<LedPoint> leds_at(const std::vector<LinearCamera>& cameras, const Quaternion& R, const Vector3& t,
                              double sd, Random& random) {
  std::vector<LedPoint> seen;
  for (const auto& led : kBody) {
    auto u = seen_by(cameras, R * led + t);
    for (auto& x : u) x += random.normal(sd);
    seen.push_back(*triangulate(cameras, u, 1e-4));
  }
  return seen;
}

TEST(BodyFit, PerfectLedsGiveThePoseForAnyRotation) {
  const auto cameras = three_cameras();
  Random random(3);
  for (int i = 0; i < 50; ++i) {
    const Quaternion R = so3_exp({random.normal(1.5), random.normal(1.5), random.normal(1.5)});
    const Vector3 t(random.uniform(-0.2, 0.2), -1.3, 1.7);
    const auto fit = fit_body(kBody, leds_at(cameras, R, t, 0.0, random));
    ASSERT_TRUE(fit);
    EXPECT_LT(angle_between(fit->rotation, R), 1e-9);
    EXPECT_LT((fit->translation - t).norm(), 1e-10);
  }
}

TEST(BodyFit, ErrorsAgreeWithTheStatedCovariance) {
  const auto cameras = three_cameras();
  Random random(5);
  const Quaternion R = so3_exp({-2.4, 0.2, 0.1});
  const Vector3 t(0.1, -1.3, 1.65);
  constexpr int kRuns = 4000;
  double mahalanobis = 0.0, chi2 = 0.0;
  for (int i = 0; i < kRuns; ++i) {
    const auto fit = fit_body(kBody, leds_at(cameras, R, t, 1e-4, random));
    Eigen::Matrix<double, 6, 1> error;
    error << so3_log(R * fit->rotation.conjugate()), t - fit->translation;
    mahalanobis += tests::normalised_square(error, fit->covariance);
    chi2 += fit->chi2;
  }
  EXPECT_TRUE(tests::is_chi_square(mahalanobis, 6 * kRuns));
  EXPECT_TRUE(tests::is_chi_square(chi2, 12 * kRuns));  // six LEDs of three components less six
}

TEST(BodyFit, RefusesTooFewLedsAndLedsInOneLine) {
  const LedPoint led{Vector3::Zero(), Matrix3::Identity()};
  const std::vector<Vector3> line{{0, 0, 0}, {0.05, 0, 0}, {0.1, 0, 0}};
  const std::vector<LedPoint> seen{
      led, {{0, 0.05, 0}, Matrix3::Identity()}, {{0, 0.1, 0}, Matrix3::Identity()}};
  EXPECT_FALSE(fit_body(line, seen));
  EXPECT_FALSE(fit_body(std::span(kBody).first(2), std::span(seen).first(2)));
}

}  // namespace
}  // namespace palpate::sim
