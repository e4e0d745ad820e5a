// Odds against the likelihood ratio by its definition: densities with the full covariance, summed over heights of the bell.
#include "applications/palpation/nodule_odds.h"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <cmath>
#include <numbers>
#include <utility>

#include "palpate/core/random.h"

namespace palpate::applications::palpation {
namespace {

struct Presses {
  std::vector<PlanPlace> places;
  std::vector<double> felt, variances;
};

Presses presses_around(const PlanPlace& nodule, double contrast, double slope) {
  Random random(4, "nodule odds test");
  Presses made;
  for (double x = -0.03; x < 0.031; x += 0.015)
    for (double z = -0.03; z < 0.031; z += 0.015) {
      const PlanPlace place(x, z);
      const double beside = (place - nodule).norm() / 0.0073;
      made.places.push_back(place);
      made.felt.push_back(-1.0 + slope * x / 0.03 + contrast * std::exp(-0.5 * beside * beside) +
                          random.normal(0.03));
      made.variances.push_back(0.02 + 0.001 * static_cast<double>(made.places.size()));
    }
  return made;
}

// Minus half of the squared distance by the covariance; the determinant is the same with and without a nodule.
double log_density(const Eigen::VectorXd& residual, const Eigen::MatrixXd& covariance) {
  return -0.5 * residual.dot(covariance.fullPivLu().solve(residual));
}

TEST(NoduleOdds, AreTheRatioOfTwoLikelihoods) {
  const auto made = presses_around({0.008, -0.004}, 0.3, 0.1);
  const NoduleOdds odds(made.places, made.felt, made.variances, false);
  const auto n = static_cast<Eigen::Index>(made.places.size());
  Eigen::MatrixXd covariance(n, n);
  Eigen::VectorXd felt(n);
  for (Eigen::Index i = 0; i < n; ++i) {
    const PlanPlace a = made.places[static_cast<std::size_t>(i)] / 0.03;
    felt[i] = made.felt[static_cast<std::size_t>(i)];
    for (Eigen::Index k = 0; k < n; ++k) {
      const PlanPlace b = made.places[static_cast<std::size_t>(k)] / 0.03;
      const double bends =
          a.x() * a.x() * b.x() * b.x() + a.x() * a.y() * b.x() * b.y() + a.y() * a.y() * b.y() * b.y();
      covariance(i, k) =
          100.0 + 0.0064 * (a.dot(b) + bends) + (i == k ? made.variances[static_cast<std::size_t>(i)] : 0.0);
    }
  }
  for (const auto& [x, z] : {std::pair{0.008, -0.004}, std::pair{-0.02, 0.01}, std::pair{0.03, 0.03}}) {
    const PlanPlace at(x, z);
    constexpr double kStep = 0.005;
    double ratio = 0.0;  // heights by half a Gaussian of 0.3
    for (double height = 0.5 * kStep; height < 2.0; height += kStep) {
      Eigen::VectorXd rest = felt;
      for (Eigen::Index i = 0; i < n; ++i) {
        const double beside = (made.places[static_cast<std::size_t>(i)] - at).norm() / 0.0073;
        if (beside <= 2.5) rest[i] -= height * std::exp(-0.5 * beside * beside);
      }
      ratio += kStep * 2.0 / (0.3 * std::sqrt(2.0 * std::numbers::pi)) *
               std::exp(-0.5 * height * height / 0.09) *
               std::exp(log_density(rest, covariance) - log_density(felt, covariance));
    }
    EXPECT_NEAR(odds.of(at), std::log(ratio), 1e-3);
  }
}

TEST(NoduleOdds, ANoduleAtTheRimIsNotTakenForASlope) {
  const PlanPlace corner(-0.027, -0.027);
  const auto made = presses_around(corner, 0.35, 0.05);
  const NoduleOdds odds(made.places, made.felt, made.variances, false);
  PlanPlace best = PlanPlace::Zero();
  for (double x = -0.036; x < 0.037; x += 0.003)
    for (double z = -0.036; z < 0.037; z += 0.003)
      if (odds.of({x, z}) > odds.of(best)) best = {x, z};
  EXPECT_LT((best - corner).norm(), 0.010);
  EXPECT_GT(odds.deviations(best), odds.deviations({0.03, 0.0}));
}

}  // namespace
}  // namespace palpate::applications::palpation
