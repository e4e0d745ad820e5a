#include "palpate/experiment/staircase.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <set>
#include <stdexcept>
#include <vector>

#include "palpate/core/random.h"
#include "palpate/experiment/psychometric.h"

namespace palpate::experiment {
namespace {

constexpr PsychometricCurve kTrue{1.0, 0.5, 0.0};
constexpr TaskShape kYes{GuessRule::fixed, 0.0, 0.06};
constexpr TaskShape kTwoPlaces{GuessRule::fixed, 0.5, 0.06};

StaircaseRule fine_rule(StaircaseKind kind, double target) {
  StaircaseRule rule;
  rule.kind = kind;
  rule.target = target;
  rule.start = 3.0;
  rule.lowest = 0.01;
  rule.highest = 100.0;
  // The last step is a tenth of the spread in its longer direction.
  const double longer = kind == StaircaseKind::weighted ? std::max(1.0, target / (1.0 - target)) : 1.0;
  rule.step_factors = {1.5, 1.2, std::exp(0.05 / longer)};
  rule.reversals = 60;
  rule.discard = 12;
  rule.most_trials = 2000;
  return rule;
}

TEST(Staircase, StepsByHand) {
  StaircaseRule rule;
  rule.start = 8.0;
  rule.lowest = 1.0;
  rule.step_factors = {2.0, 1.5};
  rule.reversals = 4;
  rule.discard = 1;
  rule.highest = 10.0;
  Staircase staircase(rule);
  std::vector<double> seen;
  for (const bool positive : {true, true, true, true, false, true, true, false}) {
    seen.push_back(staircase.stimulus());
    staircase.answer(positive);
  }
  const std::vector<double> expected{8, 8, 4, 4, 2, 3, 3, 2};
  ASSERT_EQ(seen.size(), expected.size());
  for (std::size_t i = 0; i < seen.size(); ++i) EXPECT_NEAR(seen[i], expected[i], 1e-12) << i;
  ASSERT_EQ(staircase.reversals().size(), 3u);  // at 2 upwards, at 3 downwards, at 2 upwards
  EXPECT_FALSE(staircase.finished());
  const auto threshold = staircase.threshold();
  ASSERT_TRUE(threshold);
  EXPECT_EQ(threshold->reversals, 2);
  EXPECT_NEAR(threshold->stimulus, std::sqrt(6.0), 1e-12);
  EXPECT_NEAR(threshold->log_sd, std::log(1.5) / std::sqrt(2.0), 1e-12);
  staircase.answer(true);
  staircase.answer(true);
  EXPECT_TRUE(staircase.finished());
  EXPECT_THROW(staircase.answer(true), std::logic_error);
}

// Peaks and valleys weigh the same: of three reversals that count, the first one is left out as well.
TEST(Staircase, AnEvenNumberOfReversalsCounts) {
  StaircaseRule rule;
  rule.kind = StaircaseKind::weighted;
  rule.target = 0.5;
  rule.start = 8.0;
  rule.highest = 10.0;
  rule.step_factors = {2.0};
  rule.discard = 0;
  Staircase staircase(rule);
  for (const bool positive : {true, true, false, true, false}) staircase.answer(positive);
  EXPECT_EQ(staircase.reversals().size(), 3u);  // at 2, at 4, at 2
  const auto threshold = staircase.threshold();
  ASSERT_TRUE(threshold);
  EXPECT_EQ(threshold->reversals, 2);
  EXPECT_NEAR(threshold->stimulus, std::sqrt(8.0), 1e-12);
  staircase.answer(true);
  EXPECT_EQ(staircase.threshold()->reversals, 4);
}

TEST(Staircase, TheEndsOfTheStimuliHold) {
  StaircaseRule rule;
  rule.start = 2.0;
  rule.lowest = 1.5;
  rule.highest = 2.5;
  rule.most_trials = 20;
  Staircase staircase(rule);
  while (!staircase.finished()) staircase.answer(true);
  EXPECT_EQ(staircase.stimulus(), 1.5);
  EXPECT_EQ(staircase.trials(), 20);
  EXPECT_GE(staircase.trials_at_limit(), 17);
  EXPECT_FALSE(staircase.threshold());
}

// The share of positive answers at the mean threshold of many staircases, and how it scatters.
struct Share {
  double mean = 0.0, sd_of_mean = 0.0;
};
Share share_found(const StaircaseRule& rule, const TaskShape& task, int runs) {
  Random random(11, "staircase test/share");
  double sum = 0.0, squares = 0.0;
  for (int run = 0; run < runs; ++run) {
    Staircase staircase(rule);
    while (!staircase.finished())
      staircase.answer(random.chance(chance_at(kTrue, task, staircase.stimulus()).positive));
    const double x = std::log(staircase.threshold()->stimulus);
    sum += x;
    squares += x * x;
  }
  const double mean = sum / runs, sd = std::sqrt((squares / runs - mean * mean) / runs);
  const auto share = [&](double x) { return chance_at(kTrue, task, std::exp(x)).positive; };
  return {share(mean), 0.5 * (share(mean + sd) - share(mean - sd))};
}

// With steps of a tenth of the spread the bias left is below a hundredth; it grows with the step, upwards of a half.
TEST(Staircase, ClosesInOnTheShareThatItsRuleSays) {
  for (const auto& task : {kYes, kTwoPlaces}) {
    for (const int down_after : {1, 2, 3}) {
      if (down_after == 1 && task.guess == 0.5) continue;  // a half is what guessing gives
      auto rule = fine_rule(StaircaseKind::transformed, 0.5);
      rule.down_after = down_after;
      const double sought = std::pow(0.5, 1.0 / down_after);
      EXPECT_NEAR(share_sought(rule), sought, 1e-12);
      const auto found = share_found(rule, task, 400);
      EXPECT_NEAR(found.mean, sought, 0.01 + 4.0 * found.sd_of_mean) << down_after;
    }
    for (const double target : {0.6, 0.75, 0.85}) {
      const auto found = share_found(fine_rule(StaircaseKind::weighted, target), task, 400);
      EXPECT_NEAR(found.mean, target, 0.01 + 4.0 * found.sd_of_mean) << target;
    }
  }
}

TEST(Staircase, WrongRulesAreNamedByTheirKey) {
  const auto key = [](auto change) {
    StaircaseRule rule;
    change(rule);
    const auto wrong = complaint_of(rule);
    if (wrong) {
      EXPECT_THROW(Staircase{rule}, std::invalid_argument);
    }
    return wrong ? wrong->key : std::string();
  };
  EXPECT_EQ(key([](StaircaseRule&) {}), "");
  EXPECT_EQ(key([](StaircaseRule& r) { r.down_after = 0; }), "down_after");
  EXPECT_EQ(key([](StaircaseRule& r) { r.kind = StaircaseKind::weighted, r.target = 1.0; }), "target");
  EXPECT_EQ(key([](StaircaseRule& r) { r.lowest = 0.0; }), "lowest");
  EXPECT_EQ(key([](StaircaseRule& r) { r.highest = 0.5; }), "highest");
  EXPECT_EQ(key([](StaircaseRule& r) { r.start = 9.0; }), "start");
  EXPECT_EQ(key([](StaircaseRule& r) { r.step_factors = {1.0}; }), "step_factors");
  EXPECT_EQ(key([](StaircaseRule& r) { r.step_factors.clear(); }), "step_factors");
  EXPECT_EQ(key([](StaircaseRule& r) { r.discard = 9; }), "discard");
  EXPECT_EQ(key([](StaircaseRule& r) { r.reversals = 1; }), "reversals");
  EXPECT_EQ(key([](StaircaseRule& r) { r.most_trials = 0; }), "most_trials");
}

TEST(InterleavedStaircases, EachOnceARoundInAnOrderBySeed) {
  StaircaseRule rule;
  rule.most_trials = 6;
  rule.reversals = 100;
  const auto order = [&](std::uint64_t seed) {
    InterleavedStaircases three({rule, rule, rule}, seed);
    std::vector<std::size_t> turns;
    while (!three.finished()) {
      turns.push_back(three.next());
      three.answer(true);
    }
    return turns;
  };
  const auto turns = order(1);
  ASSERT_EQ(turns.size(), 18u);
  for (std::size_t i = 0; i < turns.size(); i += 3)
    EXPECT_EQ(std::set<std::size_t>(turns.begin() + static_cast<std::ptrdiff_t>(i),
                                    turns.begin() + static_cast<std::ptrdiff_t>(i) + 3)
                  .size(),
              3u);
  EXPECT_EQ(turns, order(1));
  EXPECT_NE(turns, order(2));
}

TEST(InterleavedStaircases, ATurnWithoutAnAnswerIsCountedAndTheStimulusStays) {
  StaircaseRule rule;
  rule.most_trials = 4;
  InterleavedStaircases two({rule, rule}, 3);
  const auto whose = two.next();
  two.answer(std::nullopt);
  EXPECT_NE(two.next(), whose);
  EXPECT_EQ(two.all()[whose].trials(), 1);
  EXPECT_EQ(two.all()[whose].stimulus(), rule.start);
  int turns = 1;
  for (; !two.finished(); ++turns) two.answer(true);
  EXPECT_EQ(turns, 8);
  EXPECT_THROW((void)two.next(), std::logic_error);
}

}  // namespace
}  // namespace palpate::experiment
