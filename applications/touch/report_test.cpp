#include "applications/touch/report.h"

#include <gtest/gtest.h>

#include <cmath>

#include "palpate/core/file.h"
#include "tests/scratch_folder.h"

namespace palpate::applications::touch {
namespace {

scene::PlayReport report(const ScratchFolder& folder, const std::string& touch_csv) {
  std::filesystem::create_directories(folder / "raw");
  EXPECT_TRUE(write_file(folder / "summary.json",
                         R"({"touch": {"contact_s": 11.5, "of_s": 30.0, "touches": 4, "slips": 17,
    "force_n": {"mean": 1.41}, "friction": {"median": 0.301}, "unsettled": 2}, "force": {"peak_n": 5, "limit_n": 8.5}})"));
  EXPECT_TRUE(write_file(folder / "raw" / "touch.csv", touch_csv));
  return play_report(figures::PlayFolder::read(folder.path()).value());
}

std::vector<figures::Plot> plots(const scene::PlayReport& report) {
  std::vector<figures::Plot> all;
  for (const auto& block : report.sections.at(0).blocks)
    if (const auto* plots = std::get_if<std::vector<figures::Plot>>(&block))
      all.insert(all.end(), plots->begin(), plots->end());
  return all;
}

TEST(TouchReport, HasTheFiguresOfTheSummary) {
  const ScratchFolder folder;
  const auto told = report(folder, "time_s\n");
  EXPECT_EQ(told.figures.at(0).value, "11.5\u00a0s");
  EXPECT_EQ(told.figures.at(0).bar, "of 30\u00a0s");
  const auto& figures = std::get<std::vector<figures::Figure>>(told.sections.at(0).blocks.at(1));
  EXPECT_EQ(figures.front().verdict, figures::Verdict::holds);
  EXPECT_EQ(figures.front().bar, "at most 8.5 N, the arm's limit");
  EXPECT_EQ(figures.size(), 7u) << "two depths are not there";
  EXPECT_TRUE(plots(told).empty());
}

// Friction gives way twice, at 1.002 s after 2 ms and at 2.004 s after 3 ms, because the tip had left between them.
TEST(TouchReport, DrawsTheSecondAroundTheLongestHoldsEndAndBreaksLinesWhereTheTipLeft) {
  const ScratchFolder folder;
  const auto drawn =
      plots(report(folder,
                   "time_s,force_n,tangential_n,depth_mm,speed_mm_s,sliding,tip_x_m,tip_z_m\n"
                   "1.000,5,3,2,1,0,0.1,1.7\n1.001,5,4,2,1,0,0.1,1.7\n1.002,5,4,2,1,1,0.1,1.7\n"
                   "2.001,5,3,2,1,0,0.2,1.7\n2.002,5,3,2,1,0,0.2,1.7\n2.003,5,3,2,1,0,0.2,1.7\n"
                   "2.004,5,3,2,1,1,0.2,1.7\n"));
  ASSERT_EQ(drawn.size(), 4u);
  const auto& whole = drawn[0].series[0];
  ASSERT_EQ(whole.x.size(), 8u);
  EXPECT_TRUE(std::isnan(whole.y[3]));
  EXPECT_EQ(whole.x[0], 0.0);
  const auto &sideways = drawn[2].series[0], &normal = drawn[2].series[1];
  EXPECT_EQ(sideways.x.back(), 0.0) << "counts from the slip";
  EXPECT_EQ(normal.y.back(), 4.0) << "of 5 N, 3 N are sideways";
  EXPECT_EQ(drawn[3].series[0].x, std::vector<double>{}) << "every fifth: the first and the sixth, both held";
  EXPECT_EQ(drawn[3].series[1].x, (std::vector<double>{0.1, 0.2}));
}

}  // namespace
}  // namespace palpate::applications::touch
