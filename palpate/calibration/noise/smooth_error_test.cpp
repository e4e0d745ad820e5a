#include "palpate/calibration/noise/smooth_error.h"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <algorithm>

#include "palpate/core/random.h"

namespace palpate::calibration::noise {
namespace {

// A straight line through points of a walk in space, y = a + b x: two parameters, one component.
struct Line {
  PoseErrors errors;
  std::vector<double> x;
  explicit Line(Random& random) {
    const int n = 120;
    errors.residual = Eigen::MatrixXd::Zero(n, 1);
    errors.white = Eigen::VectorXd::Ones(n);
    errors.jacobian.assign(1, Eigen::MatrixXd(n, 2));
    for (int i = 0; i < n; ++i) {
      errors.place.emplace_back(random.uniform(-1, 1), random.uniform(-1, 1), 0.0);
      errors.turn.push_back(Quaternion::Identity());
      x.push_back(errors.place.back().x());
      errors.jacobian[0].row(i) << 1.0, x.back();
    }
    const Eigen::MatrixXd& J = errors.jacobian[0];
    errors.influence.assign(1, (J.transpose() * J).inverse() * J.transpose());
  }
};

// Mean over runs of the squared error of the slope, of what the field's covariance says of it, and of the
// field's deviation as it was told.
struct Told {
  double slope_error2 = 0.0, stated2 = 0.0, field_sd = 0.0;
};
Told run(double field_sd, double white_sd) {
  Told told;
  constexpr int kRuns = 200;
  for (int k = 0; k < kRuns; ++k) {
    Random random(static_cast<std::uint64_t>(k), "smooth-error");
    Line line(random);
    const auto n = line.errors.residual.rows();
    Eigen::VectorXd e(n);
    for (auto& value : e) value = random.normal(white_sd);
    for (int wave = 0; wave < 40; ++wave) {  // correlation length 0.4
      const Vector3 k_wave(random.normal(2.5), random.normal(2.5), 0.0);
      const double phase = random.uniform(0.0, 6.2831853), size = field_sd * std::sqrt(2.0 / 40.0);
      for (Eigen::Index i = 0; i < n; ++i)
        e[i] += size * std::cos(k_wave.dot(line.errors.place[static_cast<std::size_t>(i)]) + phase);
    }
    const Eigen::Vector2d off = line.errors.influence[0] * e;
    line.errors.residual.col(0) = e - line.errors.jacobian[0] * off;
    const auto found = smooth_error(line.errors);
    told.slope_error2 += off[1] * off[1] / kRuns;
    told.stated2 += found.covariance(1, 1) / kRuns;
    told.field_sd += found.field_sd[0] / kRuns;
  }
  return told;
}

TEST(SmoothErrorStatistics, FindsAFieldsSizeAndWhatItDoesToTheFit) {
  const auto told = run(1.0, 0.5);
  EXPECT_NEAR(told.field_sd, 1.0, 0.2);  // one draw of the field has its own size, 15 % off
  // Empirical: a recording shows one draw of its field, whose own size and length are what the estimate goes by.
  EXPECT_GT(told.stated2, 0.6 * told.slope_error2);
  EXPECT_LT(told.stated2, 1.8 * told.slope_error2);
}

TEST(SmoothErrorStatistics, WhiteNoiseIsNotTakenForAField) {
  const auto told = run(0.0, 0.5);
  EXPECT_LT(told.field_sd, 0.1);
  EXPECT_LT(told.stated2, told.slope_error2);  // white noise is counted elsewhere; this must add less
}

TEST(SmoothError, OrderOfTheRowsDoesNotMatter) {
  Random random(7, "smooth-error");
  Line line(random);
  for (auto& value : line.errors.residual.reshaped()) value = random.normal();
  const auto straight = smooth_error(line.errors);
  PoseErrors& e = line.errors;
  std::reverse(e.place.begin(), e.place.end());
  e.residual = e.residual.colwise().reverse().eval();
  e.jacobian[0] = e.jacobian[0].colwise().reverse().eval();
  e.influence[0] = e.influence[0].rowwise().reverse().eval();
  EXPECT_LT((smooth_error(e).covariance - straight.covariance).norm(), 1e-9 * straight.covariance.norm());
}

TEST(SmoothError, AStillBodyHasNoField) {
  Random random(8, "smooth-error");
  Line line(random);
  for (auto& place : line.errors.place) place = Vector3::Ones();
  EXPECT_EQ(smooth_error(line.errors).covariance.norm(), 0.0);
}

}  // namespace
}  // namespace palpate::calibration::noise
