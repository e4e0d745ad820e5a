#include "applications/touch/report.h"

#include <gtest/gtest.h>

#include <cmath>

#include "palpate/core/file.h"
#include "tests/scratch_folder.h"

namespace palpate::applications::touch {
namespace {

Json data_of(const std::string& touch_csv) {
  const ScratchFolder folder;
  std::filesystem::create_directories(folder / "raw");
  EXPECT_TRUE(write_file(folder / "summary.json", "{}"));
  EXPECT_TRUE(write_file(folder / "raw" / "touch.csv", touch_csv));
  return play_report(figures::PlayFolder::read(folder.path()).value()).data;
}

TEST(TouchReport, HasNothingToDrawWithoutTheColumnsOfATouch) {
  EXPECT_TRUE(data_of("time_s\n")["contact"].is_null());
  EXPECT_TRUE(data_of("time_s,force_n\n1,2\n")["contact"].is_null());
}

// Friction gives way twice, at 1.002 s after 2 ms and at 2.004 s after 3 ms, because the tip had left between them.
TEST(TouchReport, DrawsTheSecondAroundTheLongestHoldsEndAndBreaksLinesWhereTheTipLeft) {
  const Json data = data_of(
      "time_s,force_n,tangential_n,depth_mm,speed_mm_s,sliding,tip_x_m,tip_z_m\n"
      "1.000,5,3,2,1,0,0.1,1.7\n1.001,5,4,2,1,0,0.1,1.7\n1.002,5,4,2,1,1,0.1,1.7\n"
      "2.001,5,3,2,1,0,0.2,1.7\n2.002,5,3,2,1,0,0.2,1.7\n2.003,5,3,2,1,0,0.2,1.7\n"
      "2.004,5,3,2,1,1,0.2,1.7\n");
  const Json& contact = data["contact"];
  ASSERT_EQ(contact["time_s"].size(), 8u);
  EXPECT_TRUE(std::isnan(contact["force_n"][3].get<double>()));
  EXPECT_EQ(contact["depth_mm"].size(), 8u);
  EXPECT_EQ(contact["time_s"][0], 0.0);
  EXPECT_EQ(data["slip"]["time_s"].back(), 0.0) << "counts from the slip";
  EXPECT_EQ(data["slip"]["normal_n"].back(), 4.0) << "of 5 N, 3 N are sideways";
  EXPECT_EQ(data["path"]["slid"]["x_m"], Json::array()) << "every fifth: the first and the sixth, both held";
  EXPECT_EQ(data["path"]["held"]["x_m"], (Json{0.1, 0.2}));
}

}  // namespace
}  // namespace palpate::applications::touch
