#include "palpate/experiment/psychometric.h"

#include <gtest/gtest.h>

#include <cmath>

#include "palpate/experiment/normal.h"

namespace palpate::experiment {
namespace {

TEST(Normal, AgainstATable) {  // Abramowitz & Stegun, tables 26.1 and 26.5
  EXPECT_NEAR(normal_below(1.0), 0.841344746068543, 1e-15);
  EXPECT_NEAR(normal_below(-3.0) / 0.001349898031630, 1.0, 1e-12);
  EXPECT_NEAR(normal_density(0.5), 0.352065326764300, 1e-15);
  EXPECT_NEAR(normal_quantile(0.975), 1.959963984540, 1e-12);
  EXPECT_NEAR(normal_quantile(0.75), 0.674489750196, 1e-12);
}

TEST(Psychometric, ChancesAtThresholdAndFarFromIt) {
  const PsychometricCurve curve{2.0, 0.4, 0.04};
  const TaskShape choice{GuessRule::fixed, 0.5, 0.06}, comparison{GuessRule::equals_lapse, 0.0, 0.06};
  EXPECT_NEAR(chance_at(curve, choice, 2.0).positive, 0.5 + 0.46 / 2.0, 1e-14);
  EXPECT_NEAR(chance_at(curve, choice, 1e-9).positive, 0.5, 1e-14);
  EXPECT_NEAR(chance_at(curve, choice, 1e9).negative, 0.04, 1e-14);
  EXPECT_NEAR(chance_at(curve, comparison, 2.0).positive, 0.5, 1e-14);
  EXPECT_NEAR(chance_at(curve, comparison, 1e-9).positive, 0.04, 1e-14);
  EXPECT_NEAR(chance_at(curve, comparison, 1e9).negative, 0.04, 1e-14);
  for (const double x : {0.5, 1.7, 2.0, 3.1}) {
    const auto chance = chance_at(curve, choice, x);
    EXPECT_NEAR(chance.positive + chance.negative, 1.0, 1e-14);
    EXPECT_NEAR(stimulus_at(curve, choice, chance.positive), x, 1e-9);
  }
  EXPECT_TRUE(std::isnan(stimulus_at(curve, choice, 0.4)));
  EXPECT_TRUE(std::isnan(stimulus_at(curve, choice, 0.97)));
}

TEST(Psychometric, LevelsAreCountedAndRise) {
  const std::vector<Observation> seen{{2.0, true}, {1.0, false}, {2.0, false}, {1.0, false}, {3.0, true}};
  const auto levels = levels_of(seen);
  ASSERT_EQ(levels.size(), 3u);
  EXPECT_EQ(levels[0].stimulus, 1.0);
  EXPECT_EQ(levels[0].trials, 2);
  EXPECT_EQ(levels[0].positives, 0);
  EXPECT_EQ(levels[1].positives, 1);
  EXPECT_EQ(levels[2].positives, 1);
}

TEST(Psychometric, DevianceIsTwiceTheLogarithmOfTheLikelihoodRatio) {
  const PsychometricCurve curve{1.0, 1.0, 0.0};
  const TaskShape yes_no{GuessRule::fixed, 0.0, 0.06};
  // 7 of 10 where the curve says a half.
  const double ratio = std::pow(0.7 / 0.5, 7.0) * std::pow(0.3 / 0.5, 3.0);
  EXPECT_NEAR(deviance(curve, yes_no, std::vector<Level>{{1.0, 7, 10}}), 2.0 * std::log(ratio), 1e-12);
  EXPECT_NEAR(deviance(curve, yes_no, std::vector<Level>{{1.0, 0, 10}}), 20.0 * std::log(2.0), 1e-12);
}

// A difference of two noises, of which each is s = ln(1 + w) / (sqrt 2 x 0.674): three of four right at a ratio of 1 + w.
TEST(Psychometric, WeberFractionIsWhereThreeOfFourAreRight) {
  for (const double w : {0.08, 0.14, 0.28}) {
    const double each = std::log(1.0 + w) / (std::sqrt(2.0) * 0.6744897501960817);
    EXPECT_NEAR(spread_of_weber_fraction(w), std::sqrt(2.0) * each, 1e-12);
    EXPECT_NEAR(weber_fraction(spread_of_weber_fraction(w)), w, 1e-12);
    const TaskShape comparison{GuessRule::equals_lapse, 0.0, 0.06};
    EXPECT_NEAR(chance_at({1.0, spread_of_weber_fraction(w), 0.0}, comparison, 1.0 + w).positive, 0.75,
                1e-12);
  }
}

}  // namespace
}  // namespace palpate::experiment
