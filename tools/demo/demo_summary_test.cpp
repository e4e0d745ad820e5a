#include "tools/demo/demo_summary.h"

#include <gtest/gtest.h>

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

TEST(ClosingLines, HoldBeforeAndAfterAgainstTheSameTruth) {
  EXPECT_EQ(
      closing_lines(summary_of_a_run(), {}, "out").front(),
      "arm:      the tip 2.62 mm from the truth before calibration, 0.080 mm after (the paper's best way: "
      "0.49 mm)");
}

TEST(ClosingLines, HaveTheApplicationsBeforeTheReports) {
  const auto lines = closing_lines(summary_of_a_run(), {{"swing", "3 passes"}}, "out");
  ASSERT_EQ(lines.size(), 5u);
  EXPECT_EQ(lines[3], "swing:    3 passes");
  EXPECT_EQ(lines[4], "report:   out/report.html");
}

TEST(ClosingLines, TellTheForceWhereTheApplicationSaysNothing) {
  const auto lines = closing_lines(summary_of_a_run(), {}, "out");
  ASSERT_EQ(lines.size(), 5u);
  EXPECT_EQ(lines[3], "force:    4.73 N at most, of the 8.5 N that the arm may give");
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
