#include "applications/pingpong/report.h"

#include <gtest/gtest.h>

#include <cmath>

#include "palpate/core/file.h"
#include "tests/scratch_folder.h"

namespace palpate::applications::pingpong {
namespace {

class GameReport : public ::testing::Test {
 protected:
  void write(const std::string& name, const std::string& content) {
    std::filesystem::create_directories((folder_ / name).parent_path());
    ASSERT_TRUE(write_file(folder_ / name, content).has_value()) << name;
  }
  scene::PlayReport report(const std::string& summary) {
    write("summary.json", summary);
    return play_report(figures::PlayFolder::read(folder_.path()).value());
  }

  ScratchFolder folder_;
};

const figures::Figure& figure(const figures::Section& section, const std::string& label) {
  for (const auto& block : section.blocks)
    if (const auto* figures = std::get_if<std::vector<figures::Figure>>(&block))
      for (const auto& figure : *figures)
        if (figure.label == label) return figure;
  throw std::out_of_range(label);
}

std::vector<figures::Plot> plots(const figures::Section& section) {
  for (const auto& block : section.blocks)
    if (const auto* plots = std::get_if<std::vector<figures::Plot>>(&block)) return *plots;
  return {};
}

TEST_F(GameReport, HasNoSectionOfWhatIsNotThere) {
  EXPECT_TRUE(report("{}").sections.empty());
  EXPECT_TRUE(report("{}").figures.empty());
  const auto rally = report(R"({"rally": {"serves": 2}})");
  ASSERT_EQ(rally.sections.size(), 1u);
  EXPECT_EQ(rally.sections[0].anchor, "game");
}

TEST_F(GameReport, JudgesTheShareOfReturnsOfTwentyServesAndMore) {
  const auto of = [this](int returned, int serves) {
    return report(fmt::format(R"({{"rally": {{"serves": {}, "returned": {}}}}})", serves, returned))
        .figures.at(0);
  };
  EXPECT_EQ(of(13, 24).value, "13 of 24");
  EXPECT_EQ(of(13, 24).verdict, figures::Verdict::falls_short);
  EXPECT_EQ(of(15, 24).verdict, figures::Verdict::holds);
  EXPECT_EQ(of(1, 19).verdict, figures::Verdict::none);
  EXPECT_EQ(of(1, 19).bar, "too few for a verdict");
}

// "Rally 4" beside "1 of 2 returned" is a riddle to a stranger.
TEST_F(GameReport, SaysWhatAReturnedServeIsAndWhatARallyCounts) {
  const auto told = report(R"({"rally": {"serves": 2, "returned": 1, "longest": 4}})");
  const auto& longest = figure(told.sections.at(0), "Longest rally");
  EXPECT_EQ(longest.value, "4 returns");
  EXPECT_EQ(longest.bar, "in a row after one serve");
  EXPECT_EQ(figure(report(R"({"rally": {"serves": 2, "longest": 1}})").sections.at(0), "Longest rally").value,
            "1 return");
}

// The limit is the arm's of the play, whatever arm that was.
TEST_F(GameReport, HoldsThePeakAgainstTheLimitThatTheArmHad) {
  const auto peak = [this](const std::string& force) {
    return figure(report(R"({"force": )" + force + "}").sections.at(0), "Peak force");
  };
  EXPECT_EQ(peak(R"({"peak_n": 4.5, "limit_n": 8.5})").verdict, figures::Verdict::holds);
  EXPECT_EQ(peak(R"({"peak_n": 4.5, "limit_n": 3.3})").verdict, figures::Verdict::falls_short);
  EXPECT_EQ(peak(R"({"peak_n": 4.5, "limit_n": 3.3})").bar, "at most 3.3 N, the arm's limit");
  EXPECT_EQ(peak(R"({"peak_n": 4.5})").verdict, figures::Verdict::none);
}

TEST_F(GameReport, DrawsEveryImpactOnceAndTheStrongestMillisecondByMillisecond) {
  write("raw/haptics.csv",
        "time_s,asked_n,given_n\n1.000,0,0\n1.001,4,4\n1.002,2,2\n1.003,0,0\n"
        "2.000,0,0\n2.001,9,8\n2.002,0,0.5\n");
  write("raw/ball.csv", "time_s,x_m,y_m,z_m\n0.5,0,0,0\n");
  const auto drawn = plots(report(R"({"force": {"peak_n": 8, "limit_n": 8.5}})").sections.at(0));
  ASSERT_EQ(drawn.size(), 2u);
  const auto &strongest = drawn[0].series[0], &peaks = drawn[1].series[0];
  EXPECT_EQ(strongest.y, (std::vector<double>{0, 8, 0.5}));
  EXPECT_NEAR(strongest.x[0], -1.0, 1e-9);
  EXPECT_EQ(peaks.y, (std::vector<double>{4, 8}));
  EXPECT_NEAR(peaks.x[0], 0.501, 1e-12) << "since the first picture";
  EXPECT_EQ(drawn[1].levels.at(0).at, 8.5);
}

// A new serve begins elsewhere: no line leads there.
TEST_F(GameReport, DrawsTheBallsPathBrokenAtAServeWithTheSurfacesAroundIt) {
  write("raw/ball.csv", "time_s,x_m,y_m,z_m\n0,0,1,2\n0.03,0,1.1,1.9\n0.06,0,1,1\n");
  write("raw/surface.csv",
        "label,x_mm,y_mm,z_mm\ntable,0,1,2\ntable,1000,1,2\ntable,1000,1,0\ntable,0,1,0\n"
        "table,0,1,2\ntable,1000,1,2\ntable,1000,1,0\ntable,0,1,0\n");
  const auto drawn = plots(report(R"({"rally": {"serves": 2}})").sections.at(0));
  ASSERT_EQ(drawn.size(), 2u);
  ASSERT_EQ(drawn[0].series.size(), 2u) << "the ball, and the table once";
  const auto& side = drawn[0].series[0];
  ASSERT_EQ(side.x.size(), 4u);
  EXPECT_TRUE(std::isnan(side.x[2]));
  EXPECT_EQ(side.x[3], 1.0);
  EXPECT_EQ(side.y[1], 1.1);
  EXPECT_EQ(drawn[1].series[1].y, (std::vector<double>{0, 1, 1, 0, 0}));
}

}  // namespace
}  // namespace palpate::applications::pingpong
