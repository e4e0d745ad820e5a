#include "tools/demo/demo_summary.h"

#include <gtest/gtest.h>

#include <map>
#include <regex>

#include "palpate/core/json.h"
#include "tests/scratch_folder.h"
#include "tools/demo/demo_raw.h"
#include "tools/demo/swing_for_tests.h"

namespace palpate::tools::demo {
namespace {

Json summary_of_a_run() {
  return Json::parse(R"({
    "arm": {"uncorrected_mean_mm": 1.234, "uncorrected_error_to_truth_mm": 2.617, "error_to_truth_mean_mm": 0.0804,
      "heldout_mean_mm": 0.154, "one_pass_error_to_truth_mm": 1.2, "alternating_error_to_truth_mm": 0.51,
      "eq7_error_to_truth_mm": 0.49},
    "registration": {"world_px_rms": 0.1, "tip_px_rms": 0.2}, "exchange": {"late": 0, "frames": 90},
    "force": {"peak_n": 4.73, "limit_n": 8.5}})");
}

// The lines by what stands before their colon, in order, and the numbers that they tell.
struct Told {
  std::vector<std::string> labels;
  std::map<std::string, std::vector<double>> numbers;
};
Told told(const std::vector<scene::ClosingLine>& of_the_application, const Json& verdicts = Json::object()) {
  static const std::regex number(R"((^|[ (])([0-9]+(\.[0-9]+)?))");
  Told all;
  for (const std::string& line : closing_lines(summary_of_a_run(), of_the_application, verdicts, "out")) {
    const auto& label = all.labels.emplace_back(line.substr(0, line.find(':')));
    for (auto at = std::sregex_iterator(line.begin(), line.end(), number); at != std::sregex_iterator(); ++at)
      all.numbers[label].push_back(std::stod((*at)[2]));
  }
  return all;
}

TEST(ClosingLines, HoldBeforeAndAfterAgainstTheSameTruth) {
  EXPECT_EQ(told({}).numbers["arm"], (std::vector{2.62, 0.080, 0.49})) << "and the paper's best way";
}

TEST(ClosingLines, HaveTheApplicationsBeforeTheReports) {
  const auto lines = told({{"swing", "3 passes"}});
  ASSERT_GE(lines.labels.size(), 2u);
  EXPECT_EQ(std::vector(lines.labels.end() - 2, lines.labels.end()),
            (std::vector<std::string>{"swing", "report"}));
  EXPECT_EQ(lines.numbers.at("swing"), (std::vector{3.0}));
  EXPECT_FALSE(lines.numbers.contains("force"));
}

TEST(ClosingLines, TellWhatFallsShortBeforeTheReport) {
  const auto lines =
      told({}, Json::parse(R"({"holding": 3, "short": [{"words": "a/b_px 0.41 px, too much"}]})"));
  EXPECT_EQ(*(lines.labels.end() - 2), "falls short");
  EXPECT_EQ(lines.labels.back(), "report");
}

TEST(ClosingLines, TellTheForceWhereTheApplicationSaysNothing) {
  EXPECT_EQ(told({}).numbers["force"], (std::vector{4.73, 8.5}));
}

// Says what a summary holds.
class Counted : public scene::PlayRecord {
  std::vector<scene::ClosingLine> closing_lines(const Json& summary) const override {
    return {{"swing", fmt::format("{} passes{}", summary["swing"]["passes"].get<int>(),
                                  summary.contains("force") ? ", the program's force" : "")}};
  }
};

TEST(OwnGame, IsToldByWhatThePersonPlayedAndNotByThePlayInLockStep) {
  Json summary = summary_of_a_run();
  summary["swing"] = {{"passes", 24}};
  EXPECT_TRUE(own_game(summary, Counted()).empty());
  summary["realtime"] = {{"play", {{"swing", {{"passes", 3}}}}}, {"force", {{"peak_n", 1.5}}}};
  EXPECT_TRUE(own_game(summary, Counted()).empty()) << "a run without a window";
  summary["realtime"]["window"] = {{"played_by_mouse", false}};
  EXPECT_TRUE(own_game(summary, Counted()).empty());
  summary["realtime"]["window"] = {{"played_by_mouse", true}};
  const auto lines = own_game(summary, Counted());
  ASSERT_EQ(lines.size(), 1u);
  EXPECT_EQ(lines[0].text, "3 passes");
}

TEST(ClosingLines, HaveThePersonsGameBeforeTheProgramsAndSayWhoseIsWhose) {
  Json summary = summary_of_a_run();
  summary["realtime"] = Json::parse(
      R"({"own_game": ["3 passes"], "exchange": {"round_trip_us": {"median": 100}, "late": 0, "frames": 90},
    "sync": {"offset_error_us_p99": 10}, "haptic": {"rate_hz": 1000, "overruns": 0}})");
  const auto lines = closing_lines(summary, {{"swing", "24 passes"}}, Json::object(), "out");
  ASSERT_GE(lines.size(), 3u);
  EXPECT_EQ(lines[lines.size() - 3], "you:      3 passes");
  EXPECT_EQ(lines[lines.size() - 2], "program:  24 passes, in lock-step");
}

TEST(Tables, AreWrittenUnderTheNamesThatWereAnnounced) {
  const ScratchFolder folder;
  const auto spec = swing_for_tests();
  SwingRecord record;
  scene::SceneState state;
  state.time = Instant<PhysicsClock>{std::chrono::milliseconds(250)};
  state.bodies[0].set_p({0.5, 0.0, 0.0});
  record.add_picture(state);
  ASSERT_TRUE(write_tables(folder.path(), spec, record));
  EXPECT_EQ(read_file(folder / "swing.csv").value(), "time_s,x_m\n0.25,0.5\n");
}

TEST(Tables, RefuseANameThatIsTakenAndANumberThatWasNotAnnounced) {
  const ScratchFolder folder;
  auto spec = swing_for_tests();
  ASSERT_TRUE(write_file(folder / "swing.csv", "the system's"));
  EXPECT_EQ(write_tables(folder.path(), spec, SwingRecord()).error().message,
            "swing: its table 'swing.csv' has the name of one of the system's");
  EXPECT_EQ(read_file(folder / "swing.csv").value(), "the system's");
  spec.tables.push_back({"more.csv", "what is not kept"});
  EXPECT_EQ(write_tables(folder.path(), spec, SwingRecord()).error().message,
            "swing: its record has 1 tables; 2 were announced");
}

}  // namespace
}  // namespace palpate::tools::demo
