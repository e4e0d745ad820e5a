#include "palpate/experiment/psychometric_bootstrap.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <vector>

#include "palpate/core/random.h"
#include "tests/chi_square.h"

namespace palpate::experiment {
namespace {

constexpr TaskShape kYesOrNo{GuessRule::fixed, 0.0, 0.06};
constexpr TaskShape kOneOfTwo{GuessRule::fixed, 0.5, 0.06};

std::vector<Level> drawn_levels(const PsychometricCurve& curve, const TaskShape& task, int trials,
                                Random& random) {
  std::vector<Level> levels;
  for (int i = -3; i <= 3; ++i) {
    Level level{curve.threshold * std::exp(0.75 * i * curve.spread), 0, trials};
    const double chance = chance_at(curve, task, level.stimulus).positive;
    for (int k = 0; k < trials; ++k) level.positives += random.chance(chance) ? 1 : 0;
    levels.push_back(level);
  }
  return levels;
}

TEST(Bootstrap, OfManyTrialsItAgreesWithTheInformation) {
  Random random(2, "bootstrap test/agreement");
  const PsychometricCurve curve{1.5, 0.4, 0.03};
  const auto levels = drawn_levels(curve, kYesOrNo, 400, random);
  const auto fit = fit_psychometric(levels, kYesOrNo);
  ASSERT_TRUE(fit) << fit.error().message;
  const auto again = bootstrap(*fit, levels, kYesOrNo, {.repeats = 1000, .seed = 4});
  const auto half = [](const Interval& interval) {
    return 0.5 * std::log(interval.high / interval.low) / 1.96;
  };
  EXPECT_NEAR(half(again.threshold) / fit->log_threshold_sd, 1.0, 0.15);
  EXPECT_NEAR(half(again.spread) / fit->log_spread_sd, 1.0, 0.15);
  EXPECT_NEAR(half(fit->threshold) / fit->log_threshold_sd, 1.0, 0.15);
  EXPECT_EQ(again.without_curve, 0);
}

TEST(Bootstrap, TheSameSeedGivesTheSameFigures) {
  Random random(3, "bootstrap test/seed");
  const auto levels = drawn_levels({1.0, 0.5, 0.02}, kOneOfTwo, 30, random);
  const auto fit = fit_psychometric(levels, kOneOfTwo);
  ASSERT_TRUE(fit) << fit.error().message;
  const auto one = bootstrap(*fit, levels, kOneOfTwo, {.repeats = 100, .seed = 1}),
             same = bootstrap(*fit, levels, kOneOfTwo, {.repeats = 100, .seed = 1}),
             other = bootstrap(*fit, levels, kOneOfTwo, {.repeats = 100, .seed = 2});
  EXPECT_EQ(one.threshold.low, same.threshold.low);
  EXPECT_EQ(one.deviance_share, same.deviance_share);
  EXPECT_NE(one.threshold.low, other.threshold.low);
  EXPECT_THROW((void)bootstrap(*fit, levels, kOneOfTwo, {.repeats = 39}), std::invalid_argument);
}

// Where the model holds, the share is uniform: as many below a tenth as that says.
TEST(Bootstrap, TheDevianceShareIsUniformWhereTheCurveHolds) {
  Random random(6, "bootstrap test/uniform");
  const PsychometricCurve curve{1.0, 0.5, 0.02};
  int fits = 0, below_tenth = 0, above_half = 0;
  for (int run = 0; run < 150; ++run) {
    const auto levels = drawn_levels(curve, kYesOrNo, 30, random);
    const auto fit = fit_psychometric(levels, kYesOrNo);
    if (!fit) continue;
    ++fits;
    const double share = bootstrap(*fit, levels, kYesOrNo, {.repeats = 60, .seed = 9}).deviance_share;
    below_tenth += share < 0.1 ? 1 : 0;
    above_half += share > 0.5 ? 1 : 0;
  }
  EXPECT_GE(fits, 146);
  EXPECT_TRUE(tests::is_binomial(below_tenth, fits, 0.1));
  EXPECT_TRUE(tests::is_binomial(above_half, fits, 0.5));
}

TEST(Bootstrap, AnswersThatDependOnSomethingElseShowInTheDeviance) {
  // The threshold wanders between trials of a level, so that counts scatter beyond a binomial's.
  const std::vector<Level> levels{{0.5, 9, 40},  {0.7, 1, 40},  {0.9, 25, 40},
                                  {1.1, 12, 40}, {1.4, 38, 40}, {2.0, 31, 40}};
  const auto fit = fit_psychometric(levels, kYesOrNo);
  ASSERT_TRUE(fit) << fit.error().message;
  EXPECT_LT(bootstrap(*fit, levels, kYesOrNo, {.repeats = 500}).deviance_share, 0.01);
}

// Four trials a level: many a drawn set is a step, and its spread ends at the bound.
TEST(Bootstrap, WhereDrawnSetsAreStepsTheIntervalIsOpen) {
  const std::vector<Level> levels{{1.0, 0, 4}, {1.5, 1, 4}, {2.0, 3, 4}, {3.0, 4, 4}};
  const auto fit = fit_psychometric(levels, kYesOrNo);
  ASSERT_TRUE(fit) << fit.error().message;
  const auto again = bootstrap(*fit, levels, kYesOrNo, {.repeats = 400});
  EXPECT_GT(again.without_curve, 20);
  EXPECT_TRUE(again.spread.low_open || again.spread.low < 0.3 * fit->curve.spread);
}

}  // namespace
}  // namespace palpate::experiment
