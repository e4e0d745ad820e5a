#include "palpate/experiment/observer.h"

#include <gtest/gtest.h>

#include <cmath>
#include <stdexcept>
#include <vector>

#include "palpate/experiment/psychometric_fit.h"
#include "tests/chi_square.h"

namespace palpate::experiment {
namespace {

// Counts of a comparison with a standard of 1.
std::vector<Level> compared(Observer& observer, double fraction, int trials) {
  std::vector<Level> levels;
  for (int step = -5; step <= 5; ++step) {
    const double ratio = std::pow(1.0 + fraction, 0.75 * step);
    Level level{ratio, 0, trials};
    for (int i = 0; i < trials; ++i)
      level.positives += observer.largest(std::vector<double>{1.0, ratio}) == 1 ? 1 : 0;
    levels.push_back(level);
  }
  return levels;
}

TEST(Observer, ItsFittedCurveGivesItsWeberFractionBack) {
  for (const double w : {0.08, 0.14, 0.28}) {
    Observer observer({w, 0.02}, 5);
    const auto fit = fit_psychometric(compared(observer, w, 4000), {GuessRule::equals_lapse, 0.0, 0.06});
    ASSERT_TRUE(fit) << fit.error().message;
    const double spread_error =
        std::log(fit->curve.spread / spread_of_weber_fraction(w)) / fit->log_spread_sd;
    const double threshold_error = std::log(fit->curve.threshold) / fit->log_threshold_sd;
    EXPECT_TRUE(tests::is_chi_square(spread_error * spread_error, 1.0));
    EXPECT_TRUE(tests::is_chi_square(threshold_error * threshold_error, 1.0));
    EXPECT_NEAR(weber_fraction(fit->curve.spread) / w, 1.0, 0.06);
    EXPECT_NEAR(fit->curve.lapse, 0.01, 0.006);  // a lapse is right by lot half the time
  }
}

TEST(Observer, ThreeOfFourAreRightAtItsWeberFraction) {
  Observer observer({0.2, 0.0}, 6);
  int right = 0;
  for (int i = 0; i < 20000; ++i) right += observer.largest(std::vector<double>{1.2 * 3.0, 3.0}) == 0 ? 1 : 0;
  EXPECT_TRUE(tests::is_binomial(right, 20000, 0.75));
}

TEST(Observer, WithoutADifferenceItIsRightByChance) {
  Observer observer({0.1, 0.3}, 7);
  int third = 0, above = 0;
  for (int i = 0; i < 12000; ++i) {
    third += observer.largest(std::vector<double>{2.0, 2.0, 2.0}) == 2 ? 1 : 0;
    above += observer.is_above(1.0, 1.0) ? 1 : 0;
  }
  EXPECT_TRUE(tests::is_binomial(third, 12000, 1.0 / 3.0));
  EXPECT_TRUE(tests::is_binomial(above, 12000, 0.5));
}

// The mixture's variance is that of the formula, smaller than that of the better cue; its mean lies between, nearer to it.
TEST(Observer, CuesAreMixedByTheirReliability) {
  const std::vector<Cue> cues{{0.0, 0.1}, {0.3, 0.2}};
  const auto both = mixed(cues);
  EXPECT_NEAR(both.log_value, 0.06, 1e-12);
  EXPECT_NEAR(both.log_sd, 0.1 * 0.2 / std::hypot(0.1, 0.2), 1e-12);
  Observer observer({0.1, 0.0}, 8);
  const int n = 20000;
  double sum = 0.0, squares = 0.0;
  for (int i = 0; i < n; ++i) {
    const double x = (observer.perceived(cues) - both.log_value) / both.log_sd;
    sum += x;
    squares += x * x;
  }
  EXPECT_TRUE(tests::is_chi_square(sum * sum / n, 1.0));
  EXPECT_TRUE(tests::is_chi_square(squares, n));
  EXPECT_THROW((void)mixed({}), std::invalid_argument);
}

TEST(Observer, LearnsAsPublished) {
  EXPECT_NEAR(practised_weber_fraction(0), 0.28, 1e-12);
  EXPECT_NEAR(practised_weber_fraction(6), 0.14, 1e-12);
  EXPECT_NEAR(practised_weber_fraction(9), 0.14, 1e-12);
  for (int i = 0; i < 6; ++i) EXPECT_LT(practised_weber_fraction(i + 1), practised_weber_fraction(i));
  EXPECT_NEAR(noise_of_weber_fraction(0.14), std::log(1.14) / (std::sqrt(2.0) * 0.67449), 1e-6);
}

TEST(Observer, ModelsThatAreNoneThrow) {
  EXPECT_THROW(Observer({0.0, 0.0}, 1), std::invalid_argument);
  EXPECT_THROW(Observer({0.1, 1.5}, 1), std::invalid_argument);
}

}  // namespace
}  // namespace palpate::experiment
