#include "applications/pingpong/report.h"

#include <gtest/gtest.h>

#include <cmath>

#include "palpate/core/file.h"
#include "palpate/figures/limits.h"
#include "tests/scratch_folder.h"

namespace palpate::applications::pingpong {
namespace {

std::string_view page_file(std::string_view name) {
  for (const auto& file : page_files())
    if (file.name == name) return file.text;
  return "";
}

// Beyond what a share of returns is: too few serves say nothing about a player.
TEST(GameReport, JudgesTheShareOfReturnsOfTwentyServesAndMore) {
  const auto verdict = [](int returned, int serves) {
    const Json summary{{"rally", {{"returned", returned}, {"serves", serves}}}};
    return figures::judged(summary, page_file("pingpong-limits.toml"), "limits")
        .value()["returned"]["verdict"];
  };
  EXPECT_EQ(verdict(13, 24), "falls short");
  EXPECT_EQ(verdict(15, 24), "holds");
  EXPECT_EQ(verdict(1, 19), nullptr);
}

// A new serve begins elsewhere: no line leads there.
TEST(GameReport, BreaksTheBallsPathAtAServe) {
  const ScratchFolder folder;
  std::filesystem::create_directories(folder / "raw");
  ASSERT_TRUE(write_file(folder / "summary.json", "{}"));
  EXPECT_TRUE(play_report(figures::PlayFolder::read(folder.path()).value()).data["ball"].is_null());
  ASSERT_TRUE(
      write_file(folder / "raw" / "ball.csv", "time_s,x_m,y_m,z_m\n0,0,1,2\n0.03,0,1.1,1.9\n0.06,0,1,1\n"));
  const Json ball = play_report(figures::PlayFolder::read(folder.path()).value()).data["ball"];
  ASSERT_EQ(ball["z_m"].size(), 4u);
  EXPECT_EQ(ball["y_m"][1], 1.1);
  EXPECT_TRUE(std::isnan(ball["z_m"][2].get<double>()));
  EXPECT_EQ(ball["z_m"][3], 1.0);
}

TEST(GameReport, CountsTheTimeOfImpactsFromTheFirstPicture) {
  const ScratchFolder folder;
  std::filesystem::create_directories(folder / "raw");
  ASSERT_TRUE(write_file(folder / "summary.json", "{}"));
  // The ball is seen a moment later.
  ASSERT_TRUE(write_file(folder / "raw" / "frames.csv", "frame,state_s\n61,0.5\n62,0.53\n"));
  ASSERT_TRUE(write_file(folder / "raw" / "ball.csv", "time_s,x_m,y_m,z_m\n0.85,0,0,0\n"));
  ASSERT_TRUE(write_file(folder / "raw" / "haptics.csv", "time_s,asked_n,given_n\n1.000,0,0\n1.001,4,4\n"));
  const Json impacts = play_report(figures::PlayFolder::read(folder.path()).value()).data["impacts"];
  EXPECT_NEAR(impacts["peaks"]["time_s"][0].get<double>(), 0.501, 1e-12);
}

}  // namespace
}  // namespace palpate::applications::pingpong
