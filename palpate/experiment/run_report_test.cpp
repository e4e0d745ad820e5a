#include "palpate/experiment/run_report.h"

#include <gtest/gtest.h>

#include <vector>

#include "palpate/experiment/observer.h"

namespace palpate::experiment {
namespace {

// A comparison with a standard of 1, without sight by a worse observer; the last trial is left out.
std::vector<TrialRecord> all_answers(ExperimentRun& run, double with_sight, double without) {
  Observer sees({with_sight, 0.0}, 1), feels({without, 0.0}, 2);
  std::vector<TrialRecord> records;
  while (run.state() != RunState::finished) {
    if (run.state() == RunState::rest) run.end_rest();
    const auto trial = run.next_trial();
    auto& observer = run.level_of(trial, "sight") == "with" ? sees : feels;
    const double first = trial.target == 1 ? trial.stimulus : 1.0,
                 second = trial.target == 1 ? 1.0 : trial.stimulus;
    const bool out = run.answered() + 1 == run.most_trials();
    records.push_back(
        run.answer({.place = static_cast<int>(observer.largest(std::vector<double>{first, second})) + 1,
                    .exclusion = out ? Exclusion::tripped : Exclusion::none}));
  }
  return records;
}

TEST(RunReport, EachCellHasItsCurve) {
  auto conditions = example_conditions(Method::constant_stimuli);
  conditions.repeats = 50;
  conditions.repeat_excluded = false;
  ExperimentRun run(conditions, 3);
  const auto records = all_answers(run, 0.08, 0.2);
  const auto json = json_of(run, records, {.repeats = 100});
  EXPECT_EQ(json["name"], "stiffness");
  EXPECT_EQ(json["finished"], true);
  EXPECT_EQ(json["trials"], 2 * 8 * 50 - 1);
  EXPECT_EQ(json["practice"], 8);
  EXPECT_EQ(json["excluded"], 1);
  ASSERT_EQ(json["groups"].size(), 2u);
  EXPECT_EQ(json["groups"][0]["by"]["sight"], "with");
  EXPECT_NEAR(json["groups"][0]["weber_fraction"].get<double>(), 0.08, 0.025);
  EXPECT_NEAR(json["groups"][1]["weber_fraction"].get<double>(), 0.2, 0.06);
  EXPECT_TRUE(json["staircases"].empty());
}

TEST(RunReport, EachStaircaseHasItsThreshold) {
  ExperimentRun run(example_conditions(Method::staircase), 3);
  const auto records = all_answers(run, 0.1, 0.4);
  const auto json = json_of(run, records, {.repeats = 100});
  ASSERT_EQ(json["staircases"].size(), 4u);
  const auto& list = json["staircases"];
  for (std::size_t i = 0; i < 4; ++i) {
    EXPECT_EQ(list[i]["by"]["sight"], i < 2 ? "with" : "without");
    EXPECT_EQ(list[i]["track"], i % 2 + 1);
    EXPECT_EQ(list[i]["reversals"].size(), 10u);
    EXPECT_EQ(list[i]["threshold"].get<double>(), run.staircases()[i].threshold()->stimulus);
  }
  EXPECT_LT(list[0]["threshold"], list[2]["threshold"]);
}

TEST(RunReport, ARunWithoutAnswersIsOneToo) {
  ExperimentRun run(example_conditions(Method::staircase), 3);
  const auto json = json_of(run, {}, {.repeats = 100});
  EXPECT_EQ(json["finished"], false);
  EXPECT_EQ(json["groups"][0]["refused"]["code"], "no_trials");
  EXPECT_TRUE(json["staircases"][0]["threshold"].is_null());
}

}  // namespace
}  // namespace palpate::experiment
