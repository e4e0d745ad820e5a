#include "palpate/figures/impacts.h"

#include <gtest/gtest.h>

#include "palpate/core/file.h"
#include "tests/scratch_folder.h"

namespace palpate::figures {
namespace {

class Impacts : public ::testing::Test {
 protected:
  Json of(const std::string& haptics_csv, const char* summary = "{}") {
    std::filesystem::create_directories(folder_ / "raw");
    EXPECT_TRUE(write_file(folder_ / "summary.json", summary));
    if (!haptics_csv.empty()) {
      EXPECT_TRUE(write_file(folder_ / "raw" / "haptics.csv", haptics_csv));
    }
    EXPECT_TRUE(write_file(folder_ / "raw" / "frames.csv", "frame,state_s\n61,0.5\n62,0.53\n"));
    return impacts(PlayFolder::read(folder_.path()).value());
  }

  ScratchFolder folder_;
};

TEST_F(Impacts, AreNoneWithoutAForce) {
  EXPECT_TRUE(of("").is_null());
  EXPECT_TRUE(of("time_s,asked_n,given_n\n1,0,0\n1.001,0.0005,0\n").is_null());
}

TEST_F(Impacts, AreDrawnOnceEachAndTheStrongestMillisecondByMillisecond) {
  const Json drawn =
      of("time_s,asked_n,given_n\n1.000,0,0\n1.001,4,4\n1.002,2,2\n1.003,0,0\n2.000,0,0\n2.001,9,8\n2.002,0,"
         "0.5\n",
         R"({"force": {"limit_n": 8.5}})");
  EXPECT_EQ(drawn["strongest"]["given_n"], (Json{0.0, 8.0, 0.5}));
  EXPECT_EQ(drawn["strongest"]["asked_n"], (Json{0.0, 9.0, 0.0}));
  EXPECT_NEAR(drawn["strongest"]["ms"][0].get<double>(), -1.0, 1e-9);
  EXPECT_EQ(drawn["peaks"]["given_n"], (Json{4.0, 8.0}));
  EXPECT_NEAR(drawn["peaks"]["time_s"][0].get<double>(), 0.501, 1e-12) << "since the play began";
  EXPECT_EQ(drawn["limit_n"], 8.5);
  EXPECT_GT(drawn["range_n"][1], 8.5);
  EXPECT_TRUE(of("")["limit_n"].is_null());
}

}  // namespace
}  // namespace palpate::figures
