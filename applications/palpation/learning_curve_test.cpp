// What a file of searches shows: figures of sessions that were computed by hand, and that all of them are told.
#include "applications/palpation/learning_curve.h"

#include <gtest/gtest.h>

#include <cmath>

#include "applications/palpation/learning_study.h"
#include "palpate/core/file.h"
#include "tests/scratch_folder.h"

namespace palpate::applications::palpation {
namespace {

LearningLine line_for_tests(int session, int found, double seconds, std::optional<int> level = std::nullopt) {
  LearningLine line;
  line.session = session;
  line.date = session == 1 ? "2026-01-31T12:00:00Z" : "2026-02-01T12:00:00Z";
  line.level = level;
  line.nodules = 2;
  line.found = found;
  line.false_alarms = 2 - found;
  if (found > 0) line.position_error = 0.003;
  line.seconds = seconds;
  return line;
}

std::vector<LearningLine> lines_for_tests() {
  return {line_for_tests(1, 1, 40.0, 3), line_for_tests(1, 2, 50.0, 1), line_for_tests(1, 1, 90.0, 2),
          line_for_tests(2, 2, 30.0, 4), line_for_tests(2, 2, 20.0, 4), line_for_tests(2, 2, 25.0, 6),
          line_for_tests(2, 0, 35.0, 7)};
}

TEST(WilsonInterval, IsThatOfTheTablesAndNeverLeavesZeroToOne) {
  const auto half =
      wilson_interval(5, 10).value();  // 0.2366 to 0.7634, R's prop.test(5, 10, correct = FALSE)
  EXPECT_DOUBLE_EQ(half.share, 0.5);
  EXPECT_NEAR(half.low, 0.2366, 1e-4);
  EXPECT_NEAR(half.high, 0.7634, 1e-4);
  const auto all = wilson_interval(10, 10).value();  // 0.7225 to 1
  EXPECT_NEAR(all.low, 0.7225, 1e-4);
  EXPECT_DOUBLE_EQ(all.high, 1.0);
  EXPECT_DOUBLE_EQ(wilson_interval(0, 10)->low, 0.0);
  EXPECT_FALSE(wilson_interval(0, 0));
}

TEST(LearningCurve, TellsEachSessionsFigures) {
  const auto lines = lines_for_tests();
  const auto sessions = sessions_of(lines);
  ASSERT_EQ(sessions.size(), 2u);
  EXPECT_EQ(sessions[0].searches, 3);
  EXPECT_EQ(sessions[0].nodules, 6);
  EXPECT_EQ(sessions[0].found, 4);
  EXPECT_EQ(sessions[0].false_alarms, 2);
  EXPECT_DOUBLE_EQ(sessions[0].seconds, 50.0);
  EXPECT_DOUBLE_EQ(sessions[0].late_level.value(), 1.5) << "of three the last two";
  EXPECT_EQ(sessions[1].session, 2);
  EXPECT_EQ(sessions[1].date, "2026-02-01T12:00:00Z");
  EXPECT_DOUBLE_EQ(sessions[1].seconds, 27.5);
  EXPECT_DOUBLE_EQ(sessions[1].late_level.value(), 6.5);
  EXPECT_DOUBLE_EQ(sessions[1].found_share->share, 0.75);
  EXPECT_DOUBLE_EQ(sessions[1].position_error.value(), 0.003);
}

TEST(LearningCurve, OfDrawnNodulesHasNoLevelAndNoPlotOfLevels) {
  const std::vector<LearningLine> drawn{line_for_tests(1, 2, 40.0)};
  EXPECT_FALSE(sessions_of(drawn)[0].late_level);
  const auto with_level = learning_outcome(lines_for_tests(), "me.csv"),
             without = learning_outcome(drawn, "me.csv");
  ASSERT_EQ(with_level.sections.size(), 2u);
  EXPECT_EQ(with_level.sections[1].blocks.size(), without.sections[1].blocks.size() + 2)
      << "words and a row of plots";
  EXPECT_TRUE(without.values["sessions"][0]["level_last_half_mean"].is_null());
}

TEST(LearningCurve, IsToldInFiguresLinesAndPage) {
  const auto outcome = learning_outcome(lines_for_tests(), "me.csv");
  EXPECT_EQ(outcome.values["searches"], 7);
  ASSERT_EQ(outcome.values["sessions"].size(), 2u);
  const Json& second = outcome.values["sessions"][1];
  EXPECT_EQ(second["searches"], 4);
  EXPECT_DOUBLE_EQ(second["found_share"].get<double>(), 0.75);
  EXPECT_NEAR(second["found_share_interval"][0].get<double>(), wilson_interval(6, 8)->low, 1e-12);
  EXPECT_DOUBLE_EQ(second["false_alarms_per_search"].get<double>(), 0.5);
  EXPECT_DOUBLE_EQ(second["seconds_median"].get<double>(), 27.5);
  EXPECT_DOUBLE_EQ(second["level_last_half_mean"].get<double>(), 6.5);
  ASSERT_EQ(outcome.lines.size(), 2u);
  EXPECT_EQ(outcome.lines[0],
            "session 1 (2026-01-31): 3 searches, found 4 of 6 nodules, 67 % (30 to 90); 0.67 false alarms a "
            "search, "
            "median 50.0 s, level 1.5 in its last half");
  const auto& table = std::get<figures::Table>(outcome.sections[0].blocks[2]);
  EXPECT_EQ(table.rows.size(), 2u);
  for (const auto& row : table.rows) EXPECT_EQ(row.size(), table.header.size());
  // Each search stands in the plot of levels, as one that was answered positively or not.
  const auto& levels = std::get<std::vector<figures::Plot>>(outcome.sections[1].blocks[1])[1];
  EXPECT_EQ(levels.series[1].x.size(), 4u);
  EXPECT_EQ(levels.series[2].x.size(), 3u);
  EXPECT_EQ(levels.levels.size(), 2u) << "where each session begins";
}

TEST(LearningStudy, RefusesWhatTellsNothing) {
  const auto study = learning_study();
  scene::StudyRequest request{.settings = scene::SettingValues(study.settings)};
  const auto refusal = [&](const std::filesystem::path& file) {
    request.settings.set("study.file", file.string());
    const auto outcome = study.run(request);
    return outcome ? std::string("it ran") : outcome.error().message;
  };
  const ScratchFolder folder;
  EXPECT_NE(refusal("").find("--file: is missing"), std::string::npos);
  EXPECT_NE(refusal(folder / "gone.csv").find("no such file"), std::string::npos);
  ASSERT_TRUE(LearningFile::open(folder / "new.csv"));
  EXPECT_NE(refusal(folder / "new.csv").find("holds no search yet"), std::string::npos);
}

}  // namespace
}  // namespace palpate::applications::palpation
