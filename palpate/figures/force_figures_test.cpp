#include "palpate/figures/force_figures.h"

#include <gtest/gtest.h>

#include "palpate/core/file.h"
#include "tests/scratch_folder.h"

namespace palpate::figures {
namespace {

class ForceFigures : public ::testing::Test {
 protected:
  PlayFolder with(const std::string& force) {
    EXPECT_TRUE(write_file(folder_ / "summary.json", R"({"force": )" + force + "}"));
    return PlayFolder::read(folder_.path()).value();
  }

  ScratchFolder folder_;
};

TEST_F(ForceFigures, HoldThePeakAgainstTheArmsOwnLimit) {
  const auto weak = peak_force(with(R"({"peak_n": 4, "limit_n": 3.3})"), "Peak");
  EXPECT_EQ(weak->value, "4\u00a0N");
  EXPECT_EQ(weak->bar, "at most 3.3 N, the arm's limit");
  EXPECT_EQ(weak->verdict, Verdict::falls_short);
  EXPECT_EQ(peak_force(with(R"({"peak_n": 4, "limit_n": 8.5})"), "Peak")->verdict, Verdict::holds);
  const auto unknown = peak_force(with(R"({"peak_n": 4})"), "Peak");
  EXPECT_EQ(unknown->bar, "");
  EXPECT_EQ(unknown->verdict, Verdict::none);
  EXPECT_FALSE(peak_force(with("{}"), "Peak"));
}

// Five milliseconds "at the limit" beside a peak far below it would contradict each other.
TEST_F(ForceFigures, SayWhyAForceWasNotAsAskedForAlsoBelowTheArmsLimit) {
  const auto shaped = [this](int limited, int at_peak, bool made_up) {
    return *shaped_force(
        with(fmt::format(R"({{"limited_ticks": {}, "peak_limited_ticks": {}}})", limited, at_peak)), made_up);
  };
  EXPECT_EQ(shaped(5, 0, true).value, "5");
  EXPECT_EQ(shaped(5, 0, true).bar,
            "none cut at the arm's limit; all because a force can change by about 3\u00a0N a millisecond at "
            "most, made up for right after");
  EXPECT_EQ(shaped(7, 3, false).bar,
            "3 cut at the arm's limit; 4 because a force can change by about 3\u00a0N a millisecond at most");
  EXPECT_EQ(shaped(0, 0, true).bar, "neither the arm's limit nor that of its change was reached");
  EXPECT_EQ(shaped(2, 2, true).bar, "2 cut at the arm's limit");
  EXPECT_FALSE(shaped_force(with("{}"), true));
}

TEST_F(ForceFigures, HaveNoPlotsWithoutAnImpact) {
  EXPECT_TRUE(impact_plots(with("{}"), 0.0).empty());
  std::filesystem::create_directory(folder_ / "raw");
  ASSERT_TRUE(write_file(folder_ / "raw" / "haptics.csv", "time_s,asked_n,given_n\n1,0,0\n1.001,0.0005,0\n"));
  EXPECT_TRUE(impact_plots(with("{}"), 0.0).empty());
}

}  // namespace
}  // namespace palpate::figures
