#include "tools/demo/demo_summary.h"

#include <gtest/gtest.h>

#include "palpate/core/json.h"

namespace palpate::tools::demo {
namespace {

Json summary_of_a_run() {
  return Json::parse(R"({
    "arm": {"uncorrected_mean_mm": 1.234, "uncorrected_error_to_truth_mm": 2.617, "error_to_truth_mean_mm": 0.0804,
      "heldout_mean_mm": 0.154, "one_pass_error_to_truth_mm": 1.2, "alternating_error_to_truth_mm": 0.51,
      "eq7_error_to_truth_mm": 0.49},
    "registration": {"world_px_rms": 0.1, "tip_px_rms": 0.2}, "exchange": {"late": 0, "frames": 90},
    "rally": {"serves": 2, "returned": 1, "longest": 4}, "force": {"peak_n": 4.73}})");
}

TEST(ClosingLines, HoldBeforeAndAfterAgainstTheSameTruth) {
  EXPECT_EQ(
      closing_lines(summary_of_a_run(), "out").front(),
      "arm:      the tip 2.62 mm from the truth before calibration, 0.080 mm after (the paper's best way: "
      "0.49 mm)");
}

TEST(ClosingLines, SayWhatARallyCounts) {
  const auto lines = closing_lines(summary_of_a_run(), "out");
  ASSERT_EQ(lines.size(), 5u);
  EXPECT_EQ(
      lines[3],
      "rally:    1 of 2 serves returned to the wall, longest rally 4 returns in a row, peak force 4.7 N");
}

}  // namespace
}  // namespace palpate::tools::demo
