#include "palpate/experiment/psychometric_fit.h"

#include <gtest/gtest.h>

#include <cmath>
#include <stdexcept>
#include <vector>

#include "palpate/core/random.h"
#include "palpate/experiment/internal/likelihood_search.h"
#include "palpate/experiment/normal.h"
#include "tests/chi_square.h"

namespace palpate::experiment {
namespace {

constexpr TaskShape kChoice{GuessRule::fixed, 0.5, 0.06};
constexpr TaskShape kYesNo{GuessRule::fixed, 0.0, 0.06};
constexpr TaskShape kComparison{GuessRule::equals_lapse, 0.0, 0.06};

std::vector<double> levels_around(const PsychometricCurve& curve, int count, double reach) {
  std::vector<double> stimuli;
  for (int i = 0; i < count; ++i)
    stimuli.push_back(curve.threshold * std::exp(curve.spread * reach * (2.0 * i / (count - 1.0) - 1.0)));
  return stimuli;
}

std::vector<Level> answers_of(const PsychometricCurve& curve, const TaskShape& task,
                              const std::vector<double>& stimuli, int trials, Random& random) {
  std::vector<Level> levels;
  for (const double stimulus : stimuli) {
    Level level{stimulus, 0, trials};
    const double chance = chance_at(curve, task, stimulus).positive;
    for (int i = 0; i < trials; ++i) level.positives += random.chance(chance) ? 1 : 0;
    levels.push_back(level);
  }
  return levels;
}

// Counts as the curve has them on average, of so many trials that rounding does not matter.
std::vector<Level> average_answers(const PsychometricCurve& curve, const TaskShape& task,
                                   const std::vector<double>& stimuli) {
  constexpr int kTrials = 100'000'000;
  std::vector<Level> levels;
  for (const double stimulus : stimuli)
    levels.push_back({stimulus,
                      static_cast<int>(std::lround(kTrials * chance_at(curve, task, stimulus).positive)),
                      kTrials});
  return levels;
}

TEST(PsychometricFit, AverageAnswersGiveTheCurveBack) {
  for (const auto& task : {kChoice, kYesNo, kComparison})
    for (const PsychometricCurve curve :
         {PsychometricCurve{0.02, 0.3, 0.01}, {3.0, 0.8, 0.03}, {40.0, 1.5, 0.05}}) {
      const auto fit = fit_psychometric(average_answers(curve, task, levels_around(curve, 9, 2.5)), task);
      ASSERT_TRUE(fit) << fit.error().message;
      EXPECT_NEAR(fit->curve.threshold / curve.threshold, 1.0, 1e-4);
      EXPECT_NEAR(fit->curve.spread / curve.spread, 1.0, 1e-3);
      EXPECT_NEAR(fit->curve.lapse, curve.lapse, 1e-4);
    }
}

// Where the counts are the curve's own averages, the information is half the deviance's second derivative.
TEST(PsychometricFit, InformationIsTheDeviancesCurvature) {
  const PsychometricCurve curve{1.4, 0.6, 0.03};
  const Parameters at{std::log(curve.threshold), std::log(curve.spread), curve.lapse};
  for (const auto& task : {kChoice, kYesNo, kComparison}) {
    const auto levels = average_answers(curve, task, levels_around(curve, 7, 2.0));
    const auto information = information_at(levels, task, at);
    const double h = 1e-3;
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j <= i; ++j) {
        double second = 0.0;
        for (const int a : {-1, 1})
          for (const int b : {-1, 1}) {
            Parameters there = at;
            there[i] += a * h;
            there[j] += b * h;
            second += a * b * deviance(curve_of(there), task, levels);
          }
        second /= 4.0 * h * h;
        const double scale = std::sqrt(information(i, i) * information(j, j));
        EXPECT_NEAR(0.5 * second / scale, information(i, j) / scale, 1e-3) << i << j;
        EXPECT_EQ(information(i, j), information(j, i));
      }
  }
}

// Two levels without lapses: the probits of the two shares are a line through both, in closed form.
TEST(PsychometricFit, TwoLevelsAreTheLineThroughTheirProbits) {
  const std::vector<Level> levels{{1.0, 12, 60}, {2.0, 48, 60}};
  const TaskShape task{GuessRule::fixed, 0.0, 0.0};
  const auto fit = fit_psychometric(levels, task);
  ASSERT_TRUE(fit) << fit.error().message;
  const double low = normal_quantile(0.2), high = normal_quantile(0.8);
  const double spread = std::log(2.0) / (high - low);
  EXPECT_NEAR(fit->curve.spread, spread, 1e-6);
  EXPECT_NEAR(fit->curve.threshold, std::exp(-spread * low), 1e-6);
  EXPECT_NEAR(fit->deviance, 0.0, 1e-8);
  // sd of a probit share: sqrt(p q / n) / density.
  const double sd = std::sqrt(0.2 * 0.8 / 60.0) / normal_density(low);
  EXPECT_NEAR(fit->log_threshold_sd, spread * sd / std::sqrt(2.0), 1e-6);
}

TEST(PsychometricFit, NoPlaceOfAFineGridIsLikelier) {
  Random random(3, "fit test/grid");
  const PsychometricCurve curve{1.2, 0.4, 0.02};
  for (int run = 0; run < 5; ++run) {
    const auto levels = answers_of(curve, kChoice, levels_around(curve, 7, 2.0), 20, random);
    const auto fit = fit_psychometric(levels, kChoice);
    if (!fit) continue;
    for (int i = -20; i <= 20; ++i)
      for (int j = -20; j <= 20; ++j)
        for (int k = 0; k <= 6; ++k) {
          const PsychometricCurve other{curve.threshold * std::exp(0.05 * i),
                                        curve.spread * std::exp(0.1 * j), 0.01 * k};
          ASSERT_GE(deviance(other, kChoice, levels), fit->deviance - 1e-7);
        }
  }
}

// The profile's end by brute force: the ratio test of a held threshold, the others on a grid.
TEST(PsychometricFit, ProfileEndsAreWhereTheRatioTestSaysSo) {
  Random random(5, "fit test/profile");
  const PsychometricCurve curve{2.0, 0.5, 0.02};
  const auto levels = answers_of(curve, kChoice, levels_around(curve, 7, 2.0), 40, random);
  const auto fit = fit_psychometric(levels, kChoice);
  ASSERT_TRUE(fit) << fit.error().message;
  const auto best_with = [&](double threshold, double spread) {  // one of both held, the other 0
    double best = 1e300;
    for (int i = 0; i <= 600; ++i)
      for (int k = 0; k <= 12; ++k) {
        const double other = std::exp(-3.0 + 0.01 * i);
        best = std::min(best, deviance({threshold > 0.0 ? threshold : 2.0 * other,
                                        spread > 0.0 ? spread : other, 0.005 * k},
                                       kChoice, levels));
      }
    return best - fit->deviance;
  };
  for (const double end : {fit->threshold.low, fit->threshold.high})
    EXPECT_NEAR(best_with(end, 0.0), 3.841, 0.03);
  for (const double end : {fit->spread.low, fit->spread.high}) EXPECT_NEAR(best_with(0.0, end), 3.841, 0.03);
  EXPECT_FALSE(fit->threshold.low_open || fit->threshold.high_open || fit->spread.low_open ||
               fit->spread.high_open);
}

struct Recovery {
  int fits = 0, threshold_in = 0, spread_in = 0;
  double threshold_error = 0.0, threshold_square = 0.0, spread_error = 0.0, spread_square = 0.0;
};
Recovery recover(const PsychometricCurve& curve, const TaskShape& task, int trials, int runs) {
  Random random(7, "fit test/recovery");
  Recovery all;
  for (int run = 0; run < runs; ++run) {
    const auto fit =
        fit_psychometric(answers_of(curve, task, levels_around(curve, 8, 2.2), trials, random), task);
    if (!fit) continue;
    ++all.fits;
    const double threshold = std::log(fit->curve.threshold / curve.threshold),
                 spread = std::log(fit->curve.spread / curve.spread);
    all.threshold_error += threshold;
    all.threshold_square += threshold * threshold;
    all.spread_error += spread;
    all.spread_square += spread * spread;
    all.threshold_in +=
        fit->threshold.low <= curve.threshold && curve.threshold <= fit->threshold.high ? 1 : 0;
    all.spread_in += fit->spread.low <= curve.spread && curve.spread <= fit->spread.high ? 1 : 0;
  }
  return all;
}

// Bias within what the mean of so many scatters by. With few trials the likeliest spread is too small (here by some
// hundredths at 60 trials a level): that is the estimator's own and falls with their number.
TEST(PsychometricFit, HundredsOfObserversAreRecoveredWithoutBias) {
  for (const auto& task : {kYesNo, kChoice, kComparison}) {
    const auto all = recover({1.3, 0.5, 0.02}, task, 240, 400);
    ASSERT_EQ(all.fits, 400);
    const double n = all.fits, four = 4.0 / std::sqrt(n);
    EXPECT_NEAR(all.threshold_error / n, 0.0, four * std::sqrt(all.threshold_square / n));
    EXPECT_NEAR(all.spread_error / n, 0.0, four * std::sqrt(all.spread_square / n));
  }
}

TEST(PsychometricFit, IntervalsHoldTheTruthAsOftenAsTheySay) {
  const int runs = 400;
  for (const auto& task : {kYesNo, kChoice, kComparison}) {
    const auto all = recover({1.3, 0.5, 0.02}, task, 60, runs);
    ASSERT_EQ(all.fits, runs);
    EXPECT_TRUE(tests::is_binomial(all.threshold_in, runs, kUsualLevel));
    EXPECT_TRUE(tests::is_binomial(all.spread_in, runs, kUsualLevel));
  }
}

TEST(PsychometricFit, WithoutALapseRateLapsesPassForAWiderSpread) {
  const PsychometricCurve curve{1.0, 0.3, 0.05};
  const auto levels = average_answers(curve, kYesNo, levels_around(curve, 9, 3.0));
  const auto with = fit_psychometric(levels, kYesNo),
             without = fit_psychometric(levels, {GuessRule::fixed, 0.0, 0.0});
  ASSERT_TRUE(with && without);
  EXPECT_NEAR(with->curve.spread, 0.3, 1e-3);
  EXPECT_GT(without->curve.spread, 0.36);
}

TEST(PsychometricFit, WhatSaysNothingIsRefusedWithACode) {
  const auto verdict = [](std::vector<Level> levels, const TaskShape& task = kChoice) {
    const auto judged = judge(levels, task);
    const auto fit = fit_psychometric(levels, task);
    EXPECT_EQ(judged == DataVerdict::usable, fit.has_value());
    if (!fit) {
      EXPECT_NE(fit.error().message.find(name_of(judged)), std::string::npos) << fit.error().message;
      EXPECT_EQ(fit.error().exit_code(), 1);
    }
    return judged;
  };
  EXPECT_EQ(verdict({}), DataVerdict::no_trials);
  EXPECT_EQ(verdict({{1.0, 0, 0}, {2.0, 0, 0}}), DataVerdict::no_trials);
  EXPECT_EQ(verdict({{1.0, 7, 10}}), DataVerdict::one_level);
  EXPECT_EQ(verdict({{1e300, 7, 10}, {std::nextafter(1e300, 2e300), 9, 10}}), DataVerdict::one_level);
  EXPECT_EQ(verdict({{1.0, 10, 10}, {2.0, 10, 10}}), DataVerdict::all_positive);
  EXPECT_EQ(verdict({{1.0, 0, 10}, {2.0, 0, 10}}), DataVerdict::all_negative);
  EXPECT_EQ(verdict({{1.0, 18, 20}, {2.0, 15, 20}, {4.0, 10, 20}}), DataVerdict::no_rise);
  EXPECT_EQ(verdict({{1.0, 5, 10}, {2.0, 6, 10}, {4.0, 5, 10}}), DataVerdict::no_rise);
  EXPECT_EQ(verdict({{1.0, 0, 20}, {2.0, 0, 20}, {3.0, 20, 20}, {4.0, 20, 20}}, kYesNo),
            DataVerdict::separated);
  EXPECT_EQ(verdict({{1.0, 14, 400}, {1.02, 32, 400}, {1.04, 63, 400}}, kYesNo), DataVerdict::out_of_range);
  EXPECT_EQ(verdict({{1.0, 11, 20}, {2.0, 15, 20}, {4.0, 20, 20}}), DataVerdict::usable);
}

TEST(PsychometricFit, StimuliThatRoundingAlmostMakesOneAreNoTrouble) {
  const std::vector<Level> levels{
      {1e200, 1, 20}, {std::nextafter(1e200, 2e200), 3, 20}, {2e200, 15, 20}, {4e200, 20, 20}};
  const auto fit = fit_psychometric(levels, kYesNo);
  ASSERT_TRUE(fit) << fit.error().message;
  EXPECT_NEAR(fit->curve.threshold / 1e200, 1.6, 0.3);
}

TEST(PsychometricFit, WrongUseThrows) {
  const std::vector<Level> bad_stimulus{{0.0, 1, 2}, {1.0, 1, 2}}, too_many{{1.0, 3, 2}}, good{{1.0, 1, 2}};
  EXPECT_THROW((void)judge(bad_stimulus, kChoice), std::invalid_argument);
  EXPECT_THROW((void)judge(too_many, kChoice), std::invalid_argument);
  EXPECT_THROW((void)judge(good, {GuessRule::fixed, 0.95, 0.06}), std::invalid_argument);
  EXPECT_THROW((void)most_likely_curve(good, kChoice), std::invalid_argument);
}

}  // namespace
}  // namespace palpate::experiment
