// Experiments on the block against closed forms: shares of right answers, the threshold of fit and staircase, where late and
// not late feel alike. Forces are laws written here, so that nothing is shared with the solvers.
#include "applications/palpation/block_experiment.h"

#include <gtest/gtest.h>

#include <cmath>

#include "palpate/experiment/normal.h"
#include "palpate/experiment/run_report.h"

namespace palpate::applications::palpation {
namespace {

constexpr double kFullContrast =
    0.3;  // of ln force at a stimulus of 1; it grows in proportion to the stimulus

ForceCurve law_of(double log_contrast) {
  const double k = 1000.0 * std::exp(log_contrast);
  return {{0.001, 0.005}, {k * std::pow(0.001, 1.5), k * std::pow(0.005, 1.5)}};
}

std::map<BlockMatter, BlockPlaces> places(double contrast = kFullContrast) {
  const std::vector<double> stimuli{0.05, 0.1, 0.2, 0.4, 0.7, 1.0};
  std::vector<ForceCurve> curves;
  for (const double x : stimuli) curves.push_back(law_of(contrast * x));
  std::map<BlockMatter, BlockPlaces> all;
  all.emplace(BlockMatter::neo_hookean, BlockPlaces{law_of(0.0), NoduleSeries(stimuli, std::move(curves))});
  return all;
}

experiment::Conditions conditions(std::vector<experiment::Factor> factors, int repeats) {
  experiment::Conditions c;
  c.task = experiment::TaskKind::choice;
  c.places = 2;
  c.levels = {0.05, 0.1, 0.2, 0.4, 0.7, 1.0};
  c.repeats = repeats;
  c.factors = std::move(factors);
  return c;
}

std::vector<experiment::ObservationGroup> detected(const experiment::Conditions& c, std::uint64_t seed,
                                                   const StudiedTrainee& trainee = {}) {
  experiment::ExperimentRun run(c, seed);
  const auto answers = detect(run, places(), trainee);
  return experiment::groups_of(c, answers);
}

double chance_right(double difference, double noise, double lapse) {
  return 0.5 * lapse + (1.0 - lapse) * experiment::normal_below(difference / (std::sqrt(2.0) * noise));
}

TEST(BlockExperiment, SharesAreThoseOfTheClosedForm) {
  constexpr int kTrials = 2000;
  const StudiedTrainee trainee{.lapse_rate = 0.1};  // more than it has, so that it shows
  const auto groups = detected(conditions({{"sight", {"with", "without"}}}, kTrials), 5, trainee);
  ASSERT_EQ(groups.size(), 2u);
  for (std::size_t cell = 0; cell < 2; ++cell)
    for (const auto& level : groups[cell].levels) {
      const double noise = TraineeSenses::total_noise(sense_noise(trainee.weber_fraction), cell == 0);
      const double expected = chance_right(kFullContrast * level.stimulus, noise, trainee.lapse_rate);
      EXPECT_NEAR(static_cast<double>(level.positives) / level.trials, expected,
                  4.0 * std::sqrt(expected * (1.0 - expected) / kTrials))
          << cell << " " << level.stimulus;
    }
}

TEST(BlockExperiment, WithTheSenseOffAnswersAreByLot) {
  const auto groups = detected(conditions({{"force", {"off"}}, {"sight", {"with", "without"}}}, 500), 6);
  for (const auto& group : groups) {
    int right = 0, trials = 0;
    for (const auto& level : group.levels) right += level.positives, trials += level.trials;
    EXPECT_NEAR(static_cast<double>(right) / trials, 0.5, 4.0 * 0.5 / std::sqrt(trials));
    EXPECT_NE(experiment::judge(group.levels, {.guess = 0.5}), experiment::DataVerdict::usable);
  }
}

TEST(BlockExperiment, TwoSeedsAgreeWithinTheirIntervals) {
  const auto c = conditions({{"sight", {"with", "without"}}}, 200);
  const auto first = detected(c, 1), second = detected(c, 2), again = detected(c, 1);
  for (std::size_t cell = 0; cell < 2; ++cell) {
    const auto a = experiment::fit_psychometric(first[cell].levels, {.guess = 0.5}),
               b = experiment::fit_psychometric(second[cell].levels, {.guess = 0.5});
    ASSERT_TRUE(a && b);
    EXPECT_LT(std::max(a->threshold.low, b->threshold.low), std::min(a->threshold.high, b->threshold.high));
    EXPECT_NE(a->curve.threshold, b->curve.threshold);
    for (std::size_t k = 0; k < first[cell].levels.size(); ++k)
      EXPECT_EQ(first[cell].levels[k].positives, again[cell].levels[k].positives) << "the same seed";
  }
}

TEST(BlockExperiment, AStaircaseEndsWhereTheClosedFormHasItsShare) {
  auto c = conditions({{"sight", {"without"}}}, 1);
  c.method = experiment::Method::staircase;
  c.tracks = 60;
  c.rule = {.start = 1.0,
            .lowest = 0.05,
            .highest = 1.0,
            .step_factors = {1.3, 1.15, 1.08},
            .reversals = 20,
            .most_trials = 300};
  experiment::ExperimentRun run(c, 9);
  const StudiedTrainee trainee;
  detect(run, places(), trainee);
  double sum = 0.0;
  for (const auto& staircase : run.staircases()) sum += std::log(staircase.threshold()->stimulus);
  const double threshold = std::exp(sum / 60.0);
  const double noise = TraineeSenses::total_noise(sense_noise(trainee.weber_fraction), false);
  EXPECT_NEAR(chance_right(kFullContrast * threshold, noise, trainee.lapse_rate), std::sqrt(0.5), 0.02);
}

TEST(BlockExperiment, PractiseLowersTheThreshold) {
  const auto groups = detected(conditions({{"sessions", {"0", "6"}}, {"sight", {"without"}}}, 300), 4);
  const auto novice = experiment::fit_psychometric(groups[0].levels, {.guess = 0.5}),
             practised = experiment::fit_psychometric(groups[1].levels, {.guess = 0.5});
  ASSERT_TRUE(novice && practised);
  // Noise halves but for the roots' curvature (28 to 14 %: ln 1.28 / ln 1.14), and the threshold with it.
  EXPECT_NEAR(novice->curve.threshold / practised->curve.threshold, std::log(1.28) / std::log(1.14), 0.35);
}

// Late and not late feel alike at the ratio that makes up for the bias of the judgement, which is computed without any noise.
TEST(BlockExperiment, WhatIsLateFeelsAlikeWhereItsBiasIsMadeUpFor) {
  auto c = conditions({{"late", {"nothing", "force", "picture", "both"}}}, 300);
  c.task = experiment::TaskKind::comparison;
  c.levels = {0.5, 0.7, 0.85, 1.0, 1.2, 1.45, 2.0};
  experiment::ExperimentRun run(c, 11);
  const StudiedTrainee trainee{.late_s = 0.05};
  const auto groups = experiment::groups_of(c, compare_late(run, law_of(0.0), trainee));
  for (std::size_t cell = 0; cell < groups.size(); ++cell) {
    const auto late = situation_of(c, experiment::cells_of(c)[cell], trainee).delay;
    const auto difference = [&](double weight_of_eye) {
      const auto felt = felt_inwards(law_of(0.0), trainee.motion, late),
                 plain = felt_inwards(law_of(0.0), trainee.motion, {});
      return weight_of_eye * (log_stiffness(felt.force, felt.seen) - log_stiffness(plain.force, plain.seen)) +
             (1.0 - weight_of_eye) *
                 (log_stiffness(felt.force, felt.hand) - log_stiffness(plain.force, plain.hand));
    };
    const double bias = difference(TraineeSenses::eye_weight(sense_noise(trainee.weber_fraction)));
    const auto fit = experiment::fit_psychometric(groups[cell].levels, experiment::shape_of(c));
    ASSERT_TRUE(fit) << cell;
    EXPECT_NEAR(std::log(fit->curve.threshold), -bias, 4.0 * fit->log_threshold_sd) << cell;
  }
}

TEST(BlockExperiment, NodulesLieBetweenTheirNeighboursAndFactorsAreKnown) {
  const auto series = places().at(BlockMatter::neo_hookean).nodules;
  EXPECT_NEAR(series.at(std::sqrt(0.1 * 0.2)).log_at(0.005),
              std::log(1000.0) + 1.5 * std::log(0.005) + kFullContrast * 0.15, 1e-9);
  EXPECT_EQ(series.at(9.0).log_at(0.005), series.curves().back().log_at(0.005));
  EXPECT_THROW(situation_of(conditions({{"colour", {"red"}}}, 1), {"red"}, {}), std::invalid_argument);
}

}  // namespace
}  // namespace palpate::applications::palpation
