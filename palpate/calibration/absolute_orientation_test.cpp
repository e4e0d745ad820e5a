#include "palpate/calibration/absolute_orientation.h"

#include <gtest/gtest.h>

#include "palpate/math/random_vector.h"
#include "tests/chi_square.h"

namespace palpate::calibration {
namespace {

struct Case {
  std::vector<Vector3> from, to;
  Matrix3 R;
  Vector3 t;
};

Case make(Random& random, std::size_t n, double noise) {
  Case c;
  c.R = so3_exp(normal3(random)).toRotationMatrix();
  c.t = normal3(random);
  for (std::size_t i = 0; i < n; ++i) {
    c.from.push_back(normal3(random, 0.1));
    c.to.push_back(c.R * c.from.back() + c.t + normal3(random, noise));
  }
  return c;
}

TEST(AbsoluteOrientation, ExactPointsGiveTheExactTransform) {
  Random random(1);
  for (std::size_t n : {3u, 4u, 100u}) {
    const auto c = make(random, n, 0.0);
    const auto estimate = absolute_orientation(c.from, c.to);
    ASSERT_TRUE(estimate.has_value()) << estimate.error().message;
    EXPECT_NEAR((estimate->value.rotation - c.R).norm(), 0.0, 1e-13);
    EXPECT_NEAR((estimate->value.translation - c.t).norm(), 0.0, 1e-14 * 10);
    EXPECT_NEAR(estimate->value.rotation.determinant(), 1.0, 1e-14);
  }
}

// 40 points of three components less six parameters leave 114 freedoms to find the noise by.
TEST(AbsoluteOrientation, ErrorsAgreeWithTheCovariance) {
  Random random(2);
  double sum = 0.0;
  const int runs = 2000;
  for (int run = 0; run < runs; ++run) {
    const auto c = make(random, 40, 1e-3);
    const auto estimate = absolute_orientation(c.from, c.to);
    ASSERT_TRUE(estimate.has_value());
    Eigen::Matrix<double, 6, 1> error;
    error << so3_log(Quaternion(Matrix3(estimate->value.rotation * c.R.transpose()))),
        estimate->value.translation - c.t;
    sum += tests::normalised_square(error, estimate->covariance);
  }
  EXPECT_TRUE(tests::is_sum_of_f(sum, runs, 6, 114));
}

// The weighted optimum, against a numeric derivative of the weighted cost.
TEST(AbsoluteOrientation, WeightedFitIsAMinimumOfTheWeightedCost) {
  Random random(3);
  const auto c = make(random, 10, 0.02);
  std::vector<double> w;
  for (int i = 0; i < 10; ++i) w.push_back(random.uniform(0.0, 3.0));
  const auto estimate = absolute_orientation(c.from, c.to, w);
  ASSERT_TRUE(estimate.has_value());
  const auto cost = [&](const Vector3& turn, const Vector3& shift) {
    double sum = 0.0;
    for (std::size_t i = 0; i < w.size(); ++i)
      sum += w[i] * (c.to[i] - so3_exp(turn) * (estimate->value.rotation * c.from[i]) -
                     estimate->value.translation - shift)
                        .squaredNorm();
    return sum;
  };
  const double h = 1e-5;
  for (int k = 0; k < 3; ++k) {
    const Vector3 e = h * Vector3::Unit(k), zero = Vector3::Zero();
    EXPECT_NEAR((cost(e, zero) - cost(-e, zero)) / (2 * h), 0.0, 1e-9);
    EXPECT_NEAR((cost(zero, e) - cost(zero, -e)) / (2 * h), 0.0, 1e-9);
  }
}

TEST(AbsoluteOrientation, FarFromTheOriginVariancesStayWhatTheyAre) {
  Random random(6);
  auto c = make(random, 12, 1e-3);
  const auto near = absolute_orientation(c.from, c.to);
  ASSERT_TRUE(near.has_value());
  const double far = 1e6;  // m: squares of it leave nothing of a tenth of a metre
  for (auto& p : c.from) p.x() += far;
  for (auto& p : c.to) p += far * c.R.col(0);
  const auto moved = absolute_orientation(c.from, c.to);
  ASSERT_TRUE(moved.has_value()) << moved.error().message;
  const Matrix3 turn = near->covariance.topLeftCorner<3, 3>();
  EXPECT_LT((moved->covariance.topLeftCorner<3, 3>() - turn).norm(), 1e-3 * turn.norm());
  // The origin is a lever of 1000 km away.
  const Matrix3 lever = hat(Vector3(far * near->value.rotation.col(0)));
  const Matrix3 shift = lever * turn * lever.transpose();
  EXPECT_LT((moved->covariance.bottomRightCorner<3, 3>() - shift).norm(), 1e-3 * shift.norm());
  EXPECT_TRUE((moved->covariance.diagonal().array() > 0.0).all());
}

TEST(AbsoluteOrientation, MirroredPointsStillGiveARotationAndASign) {
  Random random(4);
  auto c = make(random, 20, 0.0);
  for (auto& p : c.to) p.x() = -p.x();
  const auto fit = fit_rigid(c.from, c.to);
  EXPECT_NEAR(fit.rotation.determinant(), 1.0, 1e-12);
  EXPECT_TRUE(fit.mirrored);
  // points in a plane cannot tell a mirror image from a turn
  for (auto& p : c.from) p.z() = 0.0;
  c.to.clear();
  for (const auto& p : c.from) c.to.push_back(c.R * p + c.t + normal3(random, 1e-4));
  EXPECT_FALSE(fit_rigid(c.from, c.to).mirrored);
}

TEST(AbsoluteOrientation, TheMisplacedPointIsNamedAndNoneAmongGoodOnes) {
  for (std::uint64_t seed = 1; seed <= 50; ++seed) {
    Random random(seed);
    auto c = make(random, 8, 1e-3);
    std::vector<double> weights(8, 1.0);
    weights[seed % 8] = 2.0;
    EXPECT_FALSE(misplaced_point(c.from, c.to, weights)) << seed;
    c.to[seed % 8] += Vector3(0.03, -0.02, 0.02);
    EXPECT_EQ(misplaced_point(c.from, c.to, weights), std::optional<std::size_t>(seed % 8)) << seed;
    std::swap(c.to[(seed + 1) % 8],
              c.to[(seed + 3) % 8]);  // two more in wrong places: no single one explains it
    EXPECT_FALSE(misplaced_point(c.from, c.to)) << seed;
  }
}

TEST(AbsoluteOrientation, StrayPointsAreToldAndNoneAmongGoodOnes) {
  for (std::uint64_t seed = 1; seed <= 50; ++seed) {
    Random random(seed);
    auto c = make(random, 40, 1e-3);
    EXPECT_TRUE(stray_points(*absolute_orientation(c.from, c.to)).empty()) << seed;
    c.to[7] += Vector3(0.03, -0.02, 0.02), c.to[20] -= Vector3(0.03, 0.03, 0.0);
    EXPECT_EQ(stray_points(*absolute_orientation(c.from, c.to)), (std::vector<std::size_t>{7, 20})) << seed;
    std::vector<double> weights(40, 1.0);
    weights[7] = 1e-4;  // known to be measured badly
    EXPECT_EQ(stray_points(*absolute_orientation(c.from, c.to, weights), weights),
              (std::vector<std::size_t>{20}))
        << seed;
  }
}

TEST(AbsoluteOrientation, TheSizeRatioIsFoundWithItsDeviation) {
  double squares = 0.0;
  constexpr int kRuns = 1000;
  for (std::uint64_t seed = 1; seed <= kRuns; ++seed) {
    Random random(seed);
    auto c = make(random, 12, 1e-3);
    for (auto& p : c.from) p /= 1.1;
    const auto size = size_ratio(c.from, c.to);
    const double off = (size.ratio - 1.1) / size.sd;
    squares += off * off;
  }
  EXPECT_TRUE(tests::is_sum_of_f(squares, kRuns, 1, 29));  // 36 components less seven parameters
}

TEST(AbsoluteOrientation, ImpossibleInputIsRefused) {
  Random random(5);
  const auto c = make(random, 5, 0.0);
  const auto refusal = [](const auto& from, const auto& to, const std::vector<double>& w = {}) {
    const auto estimate = absolute_orientation(from, to, w);
    return estimate ? std::string("none") : estimate.error().message;
  };
  EXPECT_NE(
      refusal(std::vector(c.from.begin(), c.from.begin() + 2), std::vector(c.to.begin(), c.to.begin() + 2))
          .find("at least 3"),
      std::string::npos);
  EXPECT_NE(refusal(c.from, std::vector(c.to.begin(), c.to.begin() + 2)).find("same length"),
            std::string::npos);
  EXPECT_NE(refusal(c.from, c.to, {1, 1, 0, 0, 0}).find("at least 3"), std::string::npos);
  auto broken = c.to;
  broken[2].y() = std::nan("");
  EXPECT_NE(refusal(c.from, broken).find("point 3 is not finite"), std::string::npos);
  auto millimetres = c.to;
  for (auto& p : millimetres) p *= 1000.0;
  EXPECT_NE(refusal(c.from, millimetres).find("times as large as the first"), std::string::npos);
  EXPECT_NE(refusal(millimetres, c.from).find("check the units"), std::string::npos);
  auto far = c.to;  // one stray point does not make a list larger
  far[0] *= 100.0;
  EXPECT_EQ(refusal(c.from, far).find("times as large"), std::string::npos);
  auto mirrored = c.to;
  for (auto& p : mirrored) p.x() = -p.x();
  EXPECT_NE(refusal(c.from, mirrored).find("left-handed"), std::string::npos);
  std::vector<Vector3> line, moved;
  for (int i = 0; i < 8; ++i) {
    line.push_back(0.1 * i * Vector3(1, 2, 3));
    moved.push_back(c.R * line.back());
  }
  EXPECT_NE(refusal(line, moved).find("on a line"), std::string::npos);
  // a line blurred by noise: not exactly straight, but the turn about it is still unknown
  for (auto& p : line) p += normal3(random, 2e-3);
  for (auto& p : moved) p += normal3(random, 2e-3);
  EXPECT_NE(refusal(line, moved), "none");
}

}  // namespace
}  // namespace palpate::calibration
