#include "tests/chi_square.h"

#include <cmath>
#include <limits>

#include "palpate/core/random.h"

namespace palpate::tests {
namespace {

// Percentage points as printed in tables (NIST/SEMATECH e-Handbook 1.3.6.7.4), and far tails of mpmath 1.3.
TEST(ChiSquare, QuantilesAreThoseOfTables) {
  struct Row {
    double tail, degrees;
    bool upper;
    double value, tolerance;
  };
  for (const Row& row :
       {Row{0.05, 1, true, 3.841, 5e-4}, Row{0.05, 3, true, 7.815, 5e-4}, Row{0.05, 10, false, 3.940, 5e-4},
        Row{0.025, 100, true, 129.561, 5e-4}, Row{0.001, 5, true, 20.515, 5e-4},
        Row{0.99, 20, true, 8.260, 5e-4}, Row{5e-5, 6, false, 0.136181242923021, 1e-12},
        Row{5e-5, 225, false, 151.708741423, 1e-8}, Row{5e-5, 225, true, 317.106038225, 1e-8},
        Row{5e-5, 60000, false, 58661.6736883466, 1e-5}})
    EXPECT_NEAR(chi_square_quantile(row.tail, row.degrees, row.upper), row.value, row.tolerance)
        << row.tail << " of " << row.degrees;
}

TEST(ChiSquare, TailsOfTwoDegreesAreExponentials) {
  for (const double x : {0.01, 1.0, 3.9, 4.1, 60.0}) {
    EXPECT_NEAR(chi_square_tails(x, 2).above / std::exp(-0.5 * x), 1.0, 1e-12) << x;
    EXPECT_NEAR(chi_square_tails(x, 2).below / -std::expm1(-0.5 * x), 1.0, 1e-12) << x;
  }
}

TEST(ChiSquare, SumsOfFKeepToTheirBracket) {
  Random random(1, "chi-square test");
  const auto square = [&](int degrees) {
    double sum = 0.0;
    for (int i = 0; i < degrees; ++i) sum += std::pow(random.normal(), 2);
    return sum;
  };
  constexpr int kDraws = 100;
  const double mean = kDraws * 8.0 * 16.0 / 14.0;
  const auto bracket = f_bracket(kDraws, 8, 16);
  EXPECT_LT(bracket.low, mean);
  EXPECT_GT(bracket.high, mean);
  double sum = 0.0, squares = 0.0;
  int outside = 0;
  constexpr int kSums = 2000;
  for (int i = 0; i < kSums; ++i) {
    double one = 0.0;
    for (int k = 0; k < kDraws; ++k) one += 16.0 * square(8) / square(16);
    sum += one / kSums, squares += one * one / kSums;
    outside += !is_within(one, bracket);
  }
  EXPECT_TRUE(is_binomial(outside, kSums, kFalseAlarm));
  const double sd = std::sqrt(squares - sum * sum);
  EXPECT_NEAR(sum, mean, 4.0 * sd / std::sqrt(kSums));
  EXPECT_NEAR((bracket.high - bracket.low) / (2.0 * 3.89 * sd), 1.0, 0.1);  // of a nearly normal sum
}

TEST(ChiSquare, BinomialBracketsAreThoseOfCounting) {
  // Ten coins: none or all of them once in 1024, one or fewer eleven times.
  EXPECT_EQ(binomial_bracket(10, 0.5, 2.1 / 1024).low, 1.0);
  EXPECT_EQ(binomial_bracket(10, 0.5, 1.9 / 1024).low, 0.0);
  EXPECT_EQ(binomial_bracket(10, 0.5, 21.9 / 1024).high, 9.0);
  EXPECT_EQ(binomial_bracket(10, 0.5, 22.1 / 1024).high, 8.0);
}

TEST(ChiSquare, WhatLiesOutsideIsSaid) {
  EXPECT_TRUE(is_chi_square(100.0, 100.0));
  EXPECT_FALSE(is_chi_square(170.0, 100.0));
  EXPECT_FALSE(is_chi_square(50.0, 100.0));
  EXPECT_TRUE(is_at_most_chi_square(50.0, 100.0));
  EXPECT_FALSE(is_chi_square(std::numeric_limits<double>::quiet_NaN(), 100.0));
}

}  // namespace
}  // namespace palpate::tests
