// For tests of stated uncertainties: the brackets that honest errors keep to. Errors over their stated deviations, squared
// and summed, follow the chi-square distribution with one degree of freedom for each; so a test asks for
//
//   EXPECT_TRUE(is_chi_square(sum, degrees));
//
// and neither mean nor tolerance is a matter of taste. chi_square_test.cpp has tables of others.
#pragma once

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <cmath>
#include <limits>
#include <vector>

#include "palpate/math/chi_square.h"

namespace palpate::tests {

// How often an honest estimate leaves its bracket, both sides together. Seeds are fixed: it is tried once, and again where
// a change draws other numbers. Of the tree's some fifty brackets then one fails without a fault once in two hundred times.
inline constexpr double kFalseAlarm = 1e-4;

using math::chi_square_quantile;
using math::chi_square_tails;
using math::ChiSquareTails;

struct Bracket {
  double low, high;
};
inline Bracket chi_square_bracket(double degrees, double false_alarm = kFalseAlarm) {
  return {chi_square_quantile(0.5 * false_alarm, degrees),
          chi_square_quantile(0.5 * false_alarm, degrees, true)};
}

inline testing::AssertionResult is_within(double value, const Bracket& bracket) {
  if (value >= bracket.low && value <= bracket.high) return testing::AssertionSuccess();
  return testing::AssertionFailure() << value << " is outside [" << bracket.low << ", " << bracket.high
                                     << "]";
}

inline testing::AssertionResult is_chi_square(double sum, double degrees) {
  return is_within(sum, chi_square_bracket(degrees));
}
// e' C^-1 e, in units of the stated deviations first: pixels and radians differ by many powers of ten. What is stated to be
// exact (a parameter that a kind of lens lacks) must be; it counts for nothing then.
inline double normalised_square(const Eigen::VectorXd& error, const Eigen::MatrixXd& covariance) {
  std::vector<Eigen::Index> uncertain;
  for (Eigen::Index i = 0; i < error.size(); ++i) {
    if (covariance(i, i) != 0.0)
      uncertain.push_back(i);
    else if (error[i] != 0.0)
      return std::numeric_limits<double>::infinity();
  }
  const Eigen::MatrixXd C = covariance(uncertain, uncertain);
  const Eigen::VectorXd unit = C.diagonal().cwiseSqrt().cwiseInverse();
  const Eigen::MatrixXd correlation = unit.asDiagonal() * C * unit.asDiagonal();
  const Eigen::VectorXd e = unit.cwiseProduct(Eigen::VectorXd(error(uncertain)));
  return e.dot(correlation.ldlt().solve(e));
}

// Where the estimate is cautious on purpose: its errors may be smaller than it says, and not larger.
inline testing::AssertionResult is_at_most_chi_square(double sum, double degrees) {
  return is_within(sum, {0.0, chi_square_bracket(degrees).high});
}

// Where each of `draws` estimates finds the size of its noise from its own residuals, of `freedoms` (above four): a
// normalised square of k degrees is then k F(k, freedoms). The bracket is that of the multiple of a chi-square variable
// which has the same mean and variance as the sum (Satterthwaite).
inline Bracket f_bracket(double draws, double k, double freedoms) {
  const double mean = draws * k * freedoms / (freedoms - 2.0);
  const double variance = draws * 2.0 * k * freedoms * freedoms * (k + freedoms - 2.0) /
                          ((freedoms - 2.0) * (freedoms - 2.0) * (freedoms - 4.0));
  const double scale = 0.5 * variance / mean;
  const Bracket unscaled = chi_square_bracket(mean / scale);
  return {scale * unscaled.low, scale * unscaled.high};
}
inline testing::AssertionResult is_sum_of_f(double sum, double draws, double k, double freedoms) {
  return is_within(sum, f_bracket(draws, k, freedoms));
}

// How many of `trials` come true, each with this chance: the fewest and the most.
inline Bracket binomial_bracket(int trials, double chance, double false_alarm = kFalseAlarm) {
  const auto tail = [&](int from, int step) {  // the outermost count whose tail is not too rare
    double sum = 0.0;
    for (int k = from;; k += step) {
      sum += std::exp(std::lgamma(trials + 1.0) - std::lgamma(k + 1.0) - std::lgamma(trials - k + 1.0) +
                      k * std::log(chance) + (trials - k) * std::log1p(-chance));
      if (sum > 0.5 * false_alarm) return static_cast<double>(k);
    }
  };
  return {tail(0, 1), tail(trials, -1)};
}
inline testing::AssertionResult is_binomial(int count, int trials, double chance) {
  return is_within(count, binomial_bracket(trials, chance));
}

}  // namespace palpate::tests
