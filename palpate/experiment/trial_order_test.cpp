#include "palpate/experiment/trial_order.h"

#include <gtest/gtest.h>

#include <map>
#include <set>
#include <tuple>

#include "tests/chi_square.h"

namespace palpate::experiment {
namespace {

Conditions three_by_four() {
  Conditions conditions;
  conditions.levels = {1.0, 2.0, 4.0};
  conditions.repeats = 6;
  conditions.places = 3;
  conditions.factors = {{"a", {"x", "y"}}, {"b", {"1", "2"}}};
  conditions.practice = 8;
  return conditions;
}

TEST(TrialOrder, EveryBlockHasEveryStimulusOfEveryCellOnce) {
  const auto trials = constant_trials(three_by_four(), 1);
  ASSERT_EQ(trials.size(), 6u * 12u);
  for (std::size_t block = 0; block < 6; ++block) {
    std::set<std::pair<std::size_t, double>> seen;
    for (std::size_t i = 12 * block; i < 12 * block + 12; ++i) {
      EXPECT_EQ(trials[i].block, static_cast<int>(block) + 1);
      seen.insert({trials[i].cell, trials[i].stimulus});
    }
    EXPECT_EQ(seen.size(), 12u);
  }
}

TEST(TrialOrder, ThePlaceIsBalancedForEachStimulusOfEachCell) {
  std::map<std::tuple<std::size_t, double, int>, int> counts;
  for (const auto& trial : constant_trials(three_by_four(), 2))
    ++counts[{trial.cell, trial.stimulus, trial.target}];
  EXPECT_EQ(counts.size(), 36u);
  for (const auto& [which, count] : counts) EXPECT_EQ(count, 2);
}

// Over many seeds each place in a block is taken as often by one trial as by another.
TEST(TrialOrder, NoPlaceInABlockIsPreferred) {
  auto conditions = three_by_four();
  conditions.factors.clear();
  conditions.repeats = 1;
  std::map<std::pair<std::size_t, double>, int> counts;
  const int seeds = 3000;
  for (int seed = 0; seed < seeds; ++seed) {
    const auto trials = constant_trials(conditions, static_cast<std::uint64_t>(seed));
    for (std::size_t i = 0; i < 3; ++i) ++counts[{i, trials[i].stimulus}];
  }
  for (const auto& [which, count] : counts) EXPECT_TRUE(tests::is_binomial(count, seeds, 1.0 / 3.0));
}

TEST(TrialOrder, TheSeedDecides) {
  const auto one = constant_trials(three_by_four(), 1), same = constant_trials(three_by_four(), 1),
             other = constant_trials(three_by_four(), 2);
  EXPECT_EQ(one, same);
  EXPECT_NE(one, other);
}

TEST(TrialOrder, PracticeGoesThroughAllCells) {
  const auto trials = practice_trials(three_by_four(), 1);
  ASSERT_EQ(trials.size(), 8u);
  std::map<std::size_t, int> cells;
  for (const auto& trial : trials) {
    EXPECT_TRUE(trial.practice);
    ++cells[trial.cell];
  }
  EXPECT_EQ(cells.size(), 4u);
  for (const auto& [cell, count] : cells) EXPECT_EQ(count, 2);
}

}  // namespace
}  // namespace palpate::experiment
