#include "palpate/experiment/trial_file.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <string_view>
#include <vector>

#include "palpate/core/file.h"
#include "palpate/experiment/experiment_run.h"
#include "tests/scratch_folder.h"

namespace palpate::experiment {
namespace {

Conditions few_trials() {
  auto conditions = example_conditions(Method::constant_stimuli);
  conditions.repeats = 1;
  conditions.practice = 2;
  conditions.levels = {1.0 / 3.0, 1.5};
  return conditions;
}

// Answers all, every third trial left out; written as they come.
std::vector<TrialRecord> answered(ExperimentRun& run, TrialFile& file, int most = 1000) {
  std::vector<TrialRecord> records;
  while (run.state() != RunState::finished && most-- > 0) {
    if (run.state() == RunState::rest) run.end_rest();
    const bool out = run.next_trial().number % 3 == 0 && run.next_trial().repeated == 0;
    const double n = run.next_trial().number;
    records.push_back(run.answer({.place = out ? 0 : 1 + run.next_trial().number % 2,
                                  .response_s = 0.1 * n,
                                  .time_s = n,
                                  .exclusion = out ? Exclusion::force_limited : Exclusion::none}));
    EXPECT_TRUE(file.append(records.back()));
  }
  return records;
}

TEST(TrialFile, WhatIsWrittenIsRead) {
  const ScratchFolder folder;
  const auto conditions = few_trials();
  ExperimentRun run(conditions, 18446744073709551615ull);
  auto file = TrialFile::begin(folder / "t.csv", conditions, run.seed());
  ASSERT_TRUE(file) << file.error().message;
  const auto records = answered(run, *file);
  const auto read = read_trials(folder / "t.csv", conditions);
  ASSERT_TRUE(read) << read.error().message;
  EXPECT_EQ(read->seed, run.seed());
  EXPECT_FALSE(read->cut_off);
  ASSERT_EQ(read->records.size(), records.size());
  for (std::size_t i = 0; i < records.size(); ++i) {
    EXPECT_NEAR(read->records[i].trial.stimulus, records[i].trial.stimulus, 1e-12);
    auto same = read->records[i].trial;
    same.stimulus = records[i].trial.stimulus;
    EXPECT_EQ(same, records[i].trial);
    EXPECT_EQ(read->records[i].answer.place, records[i].answer.place);
    EXPECT_EQ(read->records[i].answer.exclusion, records[i].answer.exclusion);
    EXPECT_EQ(read->records[i].answer.time_s, records[i].answer.time_s);
    EXPECT_EQ(read->records[i].positive, records[i].positive);
  }
}

// Killed at any byte: the answers before it are there, and the run goes on as if nothing had been.
TEST(TrialFile, ARunKilledAtAnyByteLosesAtMostTheTrialGoingOn) {
  const ScratchFolder folder;
  const auto conditions = few_trials();
  ExperimentRun run(conditions, 4);
  std::string whole;
  std::size_t header = 0, trials = 0;
  {
    auto file = TrialFile::begin(folder / "t.csv", conditions, 4);
    ASSERT_TRUE(file);
    header = read_file(folder / "t.csv")->size();
    trials = answered(run, *file).size();
    whole = *read_file(folder / "t.csv");
  }
  for (std::size_t bytes = header; bytes <= whole.size(); bytes += 7) {
    const auto path = folder / ("cut" + std::to_string(bytes) + ".csv");
    ASSERT_TRUE(write_file(path, std::string_view(whole).substr(0, bytes)));
    const auto lines =
        std::count(whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(bytes), '\n') - 3;
    ExperimentRun again(conditions, 4);
    {
      auto taken_up = TrialFile::take_up(path, conditions);
      ASSERT_TRUE(taken_up) << taken_up.error().message;
      auto& [file, table] = *taken_up;
      ASSERT_EQ(table.records.size(), static_cast<std::size_t>(lines));
      ASSERT_TRUE(again.take_up(table.records, path.string()));
      EXPECT_EQ(answered(again, file).size(), trials - table.records.size());
    }
    EXPECT_EQ(*read_file(path), whole);
  }
}

TEST(TrialFile, NothingIsOverwrittenAndOneWritesAtATime) {
  const ScratchFolder folder;
  const auto conditions = few_trials();
  auto file = TrialFile::begin(folder / "t.csv", conditions, 1);
  ASSERT_TRUE(file);
  const auto second = TrialFile::begin(folder / "t.csv", conditions, 1);
  ASSERT_FALSE(second);
  EXPECT_EQ(second.error().code, ErrorCode::in_use);
  const auto third = TrialFile::take_up(folder / "t.csv", conditions);
  ASSERT_FALSE(third);
  EXPECT_NE(third.error().message.find("another run is writing"), std::string::npos);
  EXPECT_FALSE(TrialFile::begin(folder / "none" / "t.csv", conditions, 1));
  const auto missing = TrialFile::take_up(folder / "none.csv", conditions);
  ASSERT_FALSE(missing);
  EXPECT_EQ(missing.error().code, ErrorCode::not_found);
}

TEST(TrialFile, FilesThatWereChangedAreNamed) {
  const ScratchFolder folder;
  const auto conditions = few_trials();
  const auto path = folder / "t.csv";
  std::string good;
  {
    ExperimentRun run(conditions, 4);
    auto file = TrialFile::begin(path, conditions, 4);
    ASSERT_TRUE(file);
    (void)answered(run, *file);
    good = *read_file(path);
  }
  const auto refusal = [&](std::string_view from, std::string_view to) {
    auto text = good;
    const auto at = text.find(from);
    EXPECT_NE(at, text.npos) << from;
    text.replace(at, from.size(), to);
    EXPECT_TRUE(write_file(path, text));
    const auto read = read_trials(path, conditions);
    return read ? std::string("none") : read.error().message;
  };
  EXPECT_NE(refusal("# palpate trials 1", "# trials").find("t.csv:1: is '# trials"), std::string::npos);
  EXPECT_NE(refusal(", seed 4", ", seed x").find("seed is 'x'"), std::string::npos);
  EXPECT_NE(refusal("practice", "training").find("first three lines"), std::string::npos);
  EXPECT_NE(refusal("force-limited", "bored").find("why is 'bored'"), std::string::npos);
  EXPECT_NE(refusal("force-limited", "").find("why is ''"), std::string::npos);
  EXPECT_NE(refusal("\n1,1,", "\n1,2,").find("t.csv:4: practice is '2'; a whole number of 0 to 1"),
            std::string::npos);
  EXPECT_NE(refusal("\n1,1,", "\nx,1,").find("t.csv:4: trial is 'x'"), std::string::npos);
  EXPECT_NE(refusal(",without\n", ",sometimes\n").find("sight is 'sometimes'; a combination"),
            std::string::npos);
  auto other = conditions;
  other.repeats = 2;
  ASSERT_TRUE(write_file(path, good));
  const auto read = read_trials(path, other);
  ASSERT_FALSE(read);
  EXPECT_NE(read.error().message.find("belongs to other conditions"), std::string::npos);
  EXPECT_EQ(read.error().exit_code(), 1);
}

}  // namespace
}  // namespace palpate::experiment
