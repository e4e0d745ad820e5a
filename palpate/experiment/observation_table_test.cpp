#include "palpate/experiment/observation_table.h"

#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <string_view>

#include "palpate/core/file.h"
#include "palpate/experiment/experiment_run.h"
#include "palpate/experiment/fit_report.h"
#include "palpate/experiment/trial_file.h"
#include "tests/scratch_folder.h"

namespace palpate::experiment {
namespace {

std::string complaint(std::string_view text, const ObservationOptions& options = {}) {
  const auto table = parse_observations(text, "t.csv", options);
  return table ? "none" : table.error().message;
}

TEST(ObservationTable, TrialsAndCountsGiveTheSameLevels) {
  const auto trials = parse_observations("response,stimulus\n1,2\n0,1\n0,2\n1,2\n", "t.csv", {});
  const auto counts = parse_observations("stimulus,trials,positives\n2,2,1\n1,1,0\n2,1,1\n", "t.csv", {});
  for (const auto* table : {&trials, &counts}) {
    ASSERT_TRUE(*table) << table->error().message;
    ASSERT_EQ((*table)->groups.size(), 1u);
    const auto& levels = (*table)->groups[0].levels;
    ASSERT_EQ(levels.size(), 2u);
    EXPECT_EQ(levels[0].stimulus, 1.0);
    EXPECT_EQ(levels[0].trials, 1);
    EXPECT_EQ(levels[1].positives, 2);
    EXPECT_EQ(levels[1].trials, 3);
    EXPECT_EQ((*table)->trials, 4);
  }
}

TEST(ObservationTable, GroupsComeInTheirOrder) {
  const auto table = parse_observations("x,y,who,hand\n1,1,eva,l\n1,0,adam,r\n2,1,eva,l\n2,1,eva,r\n",
                                        "t.csv", {"x", "y", {"who", "hand"}});
  ASSERT_TRUE(table) << table.error().message;
  ASSERT_EQ(table->groups.size(), 3u);
  EXPECT_EQ(label_of(table->groups[0]), "who eva, hand l");
  EXPECT_EQ(label_of(table->groups[1]), "who adam, hand r");
  EXPECT_EQ(table->groups[0].levels.size(), 2u);
  EXPECT_EQ(label_of({}), "all");
}

TEST(ObservationTable, WhatDoesNotCountIsLeftOut) {
  const auto table =
      parse_observations("stimulus,response,practice,excluded\n1,1,1,0\n1,0,0,1\n1,1,0,0\n", "t.csv", {});
  ASSERT_TRUE(table) << table.error().message;
  EXPECT_EQ(table->trials, 1);
  EXPECT_EQ(table->practice, 1);
  EXPECT_EQ(table->excluded, 1);
}

TEST(ObservationTable, MistakesAreNamedWithLineAndColumn) {
  EXPECT_NE(complaint("x,response\n1,1\n").find("t.csv: column 'stimulus' is missing"), std::string::npos);
  EXPECT_NE(complaint("stimulus,positives\n1,1\n").find("neither a column 'response'"), std::string::npos);
  EXPECT_NE(complaint("stimulus,response\n1,1\n-2,1\n").find("t.csv:3: stimulus is '-2'; a stimulus above 0"),
            std::string::npos);
  EXPECT_NE(complaint("stimulus,response\nweak,1\n").find("t.csv:2: stimulus is 'weak'"), std::string::npos);
  EXPECT_NE(complaint("stimulus,response\n1,0.5\n").find("t.csv:2: response is '0.5'; 1 or 0"),
            std::string::npos);
  EXPECT_NE(complaint("stimulus,response,practice\n1,1,maybe\n").find("practice is 'maybe'"),
            std::string::npos);
  EXPECT_NE(complaint("stimulus,positives,trials\n1,1.5,2\n").find("positives is '1.5'; a whole number"),
            std::string::npos);
  EXPECT_NE(complaint("stimulus,positives,trials\n1,3,2\n").find("at most 2 (trials)"), std::string::npos);
  EXPECT_NE(complaint("stimulus,response,excluded\n1,1,1\n")
                .find("no trial that counts (0 of practice, 1 left out)"),
            std::string::npos);
  EXPECT_NE(complaint("stimulus,response\n1,1\n", {"stimulus", "response", {"who"}})
                .find("column 'who' is missing"),
            std::string::npos);
  std::string many = "stimulus,response,who\n";
  for (int i = 0; i <= static_cast<int>(kMostGroups); ++i) many += "1,1,p" + std::to_string(i) + "\n";
  EXPECT_NE(complaint(many, {"stimulus", "response", {"who"}}).find("more than 200 groups"),
            std::string::npos);
}

TEST(ObservationTable, AFileOfTrialsIsOne) {
  const ScratchFolder folder;
  auto conditions = example_conditions(Method::constant_stimuli);
  conditions.practice = 3;
  ExperimentRun run(conditions, 2);
  auto file = TrialFile::begin(folder / "t.csv", conditions, 2);
  ASSERT_TRUE(file);
  int counted = 0;
  while (run.state() != RunState::finished) {
    if (run.state() == RunState::rest) run.end_rest();
    const bool out = run.next_trial().number == 20;
    const auto record = run.answer({.place = 1, .exclusion = out ? Exclusion::tripped : Exclusion::none});
    counted += record.counts() ? 1 : 0;
    ASSERT_TRUE(file->append(record));
  }
  const auto table = read_observations(folder / "t.csv", {"stimulus", "response", {"sight"}});
  ASSERT_TRUE(table) << table.error().message;
  EXPECT_EQ(table->groups.size(), 2u);
  EXPECT_EQ(table->trials, counted);
  EXPECT_EQ(table->practice, 3);
  EXPECT_EQ(table->excluded, 1);
}

TEST(FitReport, FiguresAndRefusalsAsJson) {
  const TaskShape comparison{GuessRule::equals_lapse, 0.0, 0.06};
  const ObservationGroup good{{{"sight", "with"}},
                              {{0.7, 3, 40}, {0.9, 12, 40}, {1.1, 27, 40}, {1.4, 38, 40}}};
  const auto fit = fit_group(good, comparison, {.repeats = 100});
  ASSERT_TRUE(fit.fit) << fit.refusal;
  const auto json = json_of(fit, comparison);
  EXPECT_EQ(json["by"]["sight"], "with");
  EXPECT_EQ(json["trials"], 160);
  EXPECT_EQ(json["threshold"].get<double>(), fit.fit->curve.threshold);
  EXPECT_NEAR(json["weber_fraction"].get<double>(), std::exp(0.6744898 * fit.fit->curve.spread) - 1.0, 1e-6);
  EXPECT_NEAR(json["stimulus_at_75"].get<double>() / fit.fit->curve.threshold,
              1.0 + json["weber_fraction"].get<double>(), 0.02);
  EXPECT_NE(line_of(fit, comparison).find("sight with: threshold"), std::string::npos);
  const auto none = fit_group({{}, {{1.0, 4, 4}, {2.0, 4, 4}}}, comparison, {.repeats = 100});
  EXPECT_FALSE(none.fit);
  const auto refused_json = json_of(none, comparison);
  EXPECT_EQ(refused_json["refused"]["code"], "all_positive");
  EXPECT_FALSE(refused_json.contains("threshold"));
}

}  // namespace
}  // namespace palpate::experiment
