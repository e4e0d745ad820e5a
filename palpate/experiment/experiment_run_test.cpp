#include "palpate/experiment/experiment_run.h"

#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <stdexcept>
#include <utility>
#include <vector>

#include "palpate/experiment/observer.h"
#include "palpate/experiment/psychometric_fit.h"
#include "tests/chi_square.h"

namespace palpate::experiment {
namespace {

Conditions small(Method method) {
  auto conditions = example_conditions(method);
  conditions.repeats = 2;
  conditions.rest_after = 10;
  conditions.practice = 4;
  conditions.rule.most_trials = 9;
  return conditions;
}

// The place of a comparison with a standard of 1 that an observer takes.
int taken(Observer& observer, const Trial& trial) {
  const double at_target[] = {trial.stimulus, 1.0}, at_other[] = {1.0, trial.stimulus};
  return static_cast<int>(observer.largest(trial.target == 1 ? at_target : at_other)) + 1;
}

struct Played {
  std::vector<TrialRecord> records;
  int rests = 0;
};
Played play(ExperimentRun& run, Observer& observer, int most = 1'000'000) {
  Played played;
  while (run.state() != RunState::finished && most > 0) {
    if (run.state() == RunState::rest) {
      ++played.rests;
      run.end_rest();
      continue;
    }
    --most;
    played.records.push_back(run.answer({.place = taken(observer, run.next_trial()), .response_s = 1.0}));
  }
  return played;
}

TEST(ExperimentRun, PracticeRestsAndTrialsInTheirOrder) {
  ExperimentRun run(small(Method::constant_stimuli), 1);
  Observer observer({0.14, 0.0}, 1);
  const auto played = play(run, observer);
  ASSERT_EQ(played.records.size(), 4u + 2u * 8u * 2u);
  EXPECT_EQ(run.most_trials(), 36);
  EXPECT_EQ(run.answered(), 36);
  EXPECT_EQ(played.rests, 1 + 3);  // after practice, after 10, 20 and 30 of 32
  for (std::size_t i = 0; i < played.records.size(); ++i) {
    EXPECT_EQ(played.records[i].trial.number, static_cast<int>(i) + 1);
    EXPECT_EQ(played.records[i].trial.practice, i < 4);
    EXPECT_EQ(played.records[i].counts(), i >= 4);
  }
  EXPECT_THROW((void)run.next_trial(), std::logic_error);
  EXPECT_THROW(run.end_rest(), std::logic_error);
}

TEST(ExperimentRun, TrialsLeftOutComeAgainAtTheEndAndNotForEver) {
  for (const bool again : {true, false}) {
    auto conditions = small(Method::constant_stimuli);
    conditions.practice = 0;
    conditions.rest_after = 0;
    conditions.repeat_excluded = again;
    ExperimentRun run(conditions, 3);
    std::map<std::pair<std::size_t, double>, int> counted;
    const Trial first = run.next_trial();
    int trials = 0, of_first = 0;
    for (; run.state() == RunState::trial; ++trials) {
      const auto trial = run.next_trial();
      const bool out =
          trial.cell == first.cell && trial.stimulus == first.stimulus && trial.block == first.block;
      of_first += out ? 1 : 0;
      const auto record =
          run.answer({.place = out ? 0 : 1, .exclusion = out ? Exclusion::tripped : Exclusion::none});
      if (record.counts()) ++counted[{trial.cell, trial.stimulus}];
    }
    EXPECT_EQ(of_first, again ? 1 + kMostRepeats : 1);
    EXPECT_EQ(trials, 32 + of_first - 1);
    EXPECT_EQ((counted[{first.cell, first.stimulus}]), 1);
  }
}

TEST(ExperimentRun, AStaircaseStaysWhereATrialIsLeftOut) {
  auto conditions = small(Method::staircase);
  conditions.practice = 0;
  conditions.rest_after = 0;
  conditions.tracks = 1;
  conditions.factors.clear();
  ExperimentRun run(conditions, 1);
  const double start = run.next_trial().stimulus;
  (void)run.answer({.exclusion = Exclusion::force_limited});
  EXPECT_EQ(run.next_trial().stimulus, start);
  int trials = 1;
  for (; run.state() == RunState::trial; ++trials) (void)run.answer({.exclusion = Exclusion::tripped});
  EXPECT_EQ(trials, 9);
  EXPECT_EQ(run.staircases().size(), 1u);
}

TEST(ExperimentRun, IsTakenUpWhereItWasBrokenOff) {
  for (const auto method : {Method::constant_stimuli, Method::staircase}) {
    ExperimentRun whole(small(method), 5);
    Observer observer({0.14, 0.05}, 2);
    const auto all = play(whole, observer).records;
    for (const std::size_t done : {std::size_t{0}, std::size_t{3}, std::size_t{14}, all.size()}) {
      ExperimentRun again(small(method), 5);
      ASSERT_TRUE(again.take_up(std::span(all).first(done), "t.csv"));
      std::vector<TrialRecord> rest;
      for (std::size_t i = done; again.state() != RunState::finished; ++i) {
        if (again.state() == RunState::rest) again.end_rest();
        ASSERT_EQ(again.next_trial(), all[i].trial);
        (void)again.answer(all[i].answer);
      }
    }
    ExperimentRun other(small(method), 6);
    const auto refusal = other.take_up(all, "t.csv");
    ASSERT_FALSE(refusal);
    EXPECT_NE(refusal.error().message.find("t.csv: trial "), std::string::npos);
    auto forged = all;
    forged[5].positive = !forged[5].positive;
    ExperimentRun third(small(method), 5);
    const auto told = third.take_up(forged, "t.csv");
    ASSERT_FALSE(told);
    EXPECT_NE(told.error().message.find("trial 6: response"), std::string::npos);
    forged[5].answer.place = 3;
    ExperimentRun nowhere(small(method), 5);
    EXPECT_FALSE(nowhere.take_up(forged, "t.csv"));
    auto longer = all;
    longer.push_back(all.back());
    ExperimentRun fourth(small(method), 5);
    EXPECT_FALSE(fourth.take_up(longer, "t.csv"));
  }
}

TEST(ExperimentRun, AnAnswerThatNamesNoPlaceThrows) {
  ExperimentRun run(small(Method::constant_stimuli), 1);
  EXPECT_THROW((void)run.answer({.place = 0}), std::invalid_argument);
  EXPECT_THROW((void)run.answer({.place = 3}), std::invalid_argument);
  EXPECT_EQ(run.answered(), 0);
  EXPECT_EQ(run.level_of(run.next_trial(), "sight").substr(0, 4), "with");
  EXPECT_THROW((void)run.level_of(run.next_trial(), "smell"), std::out_of_range);
}

// The whole way: an observer with a known Weber fraction goes through an experiment, and the fit gives it back.
TEST(ExperimentRun, AWholeExperimentFindsTheObserversWeberFraction) {
  auto conditions = example_conditions(Method::constant_stimuli);
  conditions.repeats = 200;
  ExperimentRun run(conditions, 7);
  Observer observer({0.2, 0.02}, 3);
  std::vector<Observation> counted;
  for (const auto& record : play(run, observer).records)
    if (record.counts()) counted.push_back({record.trial.stimulus, record.positive});
  ASSERT_EQ(counted.size(), 3200u);
  const auto fit = fit_psychometric(levels_of(counted), shape_of(conditions));
  ASSERT_TRUE(fit) << fit.error().message;
  const double error = std::log(fit->curve.spread / spread_of_weber_fraction(0.2)) / fit->log_spread_sd;
  EXPECT_TRUE(tests::is_chi_square(error * error, 1.0));
}

// A two-down-one-up staircase seeks 70.7 % right, which this observer is at a ratio of exp(0.545 spread).
TEST(ExperimentRun, StaircasesOfAnExperimentCloseInOnTheObserversThreshold) {
  auto conditions = example_conditions(Method::staircase);
  conditions.rule.step_factors = {1.2, 1.1, 1.05, 1.05, 1.03};
  conditions.rule.reversals = 40;
  conditions.rule.discard = 10;
  conditions.rule.most_trials = 500;
  conditions.tracks = 90;
  ExperimentRun run(conditions, 9);
  Observer observer({0.2, 0.0}, 4);
  (void)play(run, observer);
  ASSERT_EQ(run.staircases().size(), 180u);
  double sum = 0.0, squares = 0.0;
  for (const auto& staircase : run.staircases()) {
    const double x = std::log(staircase.threshold()->stimulus);
    sum += x;
    squares += x * x;
  }
  const double mean = sum / 180.0, sd_of_mean = std::sqrt((squares / 180.0 - mean * mean) / 180.0);
  const double sought = spread_of_weber_fraction(0.2) * 0.5449521356;  // z of 0.70711
  EXPECT_NEAR(mean, sought, 4.0 * sd_of_mean + 0.02 * sought);
}

}  // namespace
}  // namespace palpate::experiment
