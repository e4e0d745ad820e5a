#include "tools/demo/report_data.h"

#include <gtest/gtest.h>

#include "tools/demo/play_folder_for_tests.h"

namespace palpate::tools::demo {
namespace {

class ReportData : public PlayFolderTest {
 protected:
  figures::PlayFolder play() { return figures::PlayFolder::read(folder_).value(); }
};

TEST_F(ReportData, IsEmptyWhereThereAreNoTables) {
  EXPECT_TRUE(calibration_data(play()).empty());
  EXPECT_TRUE(network_data(play()).empty());
  EXPECT_FALSE(realtime_data(play())["no_late_answers"].get<bool>());
}

// 0.36 / sqrt(30) is 0.5 / sqrt(57.9).
TEST_F(ReportData, TellsWhatThirtyGuidedPosesAreWorth) {
  write_raw();
  EXPECT_EQ(calibration_data(play())["guidance"]["worth_poses"], 58.0);
  write("raw/arm_guidance.csv", "poses,guided_mm,chosen_mm\n29,0.2,0.4\n30,0.1,0.3\n31,0.1,0.2\n");
  const Json guidance = calibration_data(play())["guidance"];
  EXPECT_TRUE(guidance["worth_poses"].is_null());
  EXPECT_EQ(guidance["most_poses"], 31.0);
}

// A stroke leads from the true place to ten times the error, and then the pen is lifted.
TEST_F(ReportData, DrawsErrorsTenTimesAsLongAsTheyAre) {
  write("raw/arm_errors.csv",
        "method,pose,error_mm,x_mm,y_mm,z_mm,dx_mm,dy_mm,dz_mm\njoint,1,0.5,10,20,30,0.3,0,-0.4\n");
  const Json data = calibration_data(play());
  EXPECT_EQ(Json::parse(data["arm_strokes"]["joint"].dump()),
            Json::parse("[10.0, 20.0, 30.0, 13.0, 20.0, 26.0, null, null, null]"));
  EXPECT_EQ(data["arm_shares"]["joint"]["y"], Json{1.0});
}

TEST_F(ReportData, OutlinesEachSurfaceOnce) {
  write("raw/surface.csv",
        "label,x_mm,y_mm,z_mm\ntable,0,1,2\ntable,1000,1,2\ntable,1000,1,0\ntable,0,1,0\n"
        "table,0,1,2\ntable,1000,1,2\ntable,1000,1,0\ntable,0,1,0\n");
  const Json surfaces = play_data(play())["surfaces"];
  ASSERT_EQ(surfaces.size(), 1u);
  EXPECT_EQ(surfaces[0]["x_m"], (Json{0.0, 1.0, 1.0, 0.0, 0.0}));
}

// Counts of half octaves as they stand in the file, whatever is quicker than 0.128 us in one column, and how much the
// counts grew in each second.
TEST_F(ReportData, HasTheInstrumentsOfTheLoops) {
  write("raw/realtime_jitter.csv",
        "loop,late_from_us,late_to_us,ticks\nhaptic,0.008,0.016,7000\nhaptic,0.064,0.096,1000\n"
        "haptic,96,128,31\nphysics,24.576,32.768,9000\n");
  write("raw/realtime_loops.csv",
        "time_s,haptic_ticks,physics_ticks,haptic_overruns,haptic_missed,physics_overruns,physics_missed\n"
        "-0.5,500,500,4,9,0,0\n0.5,1500,1500,4,9,0,0\n1.5,2500,2500,6,12,1,0\n2.5,3500,3500,6,12,1,0\n");
  const Json data = realtime_data(play());
  EXPECT_EQ(data["jitter"]["loops"]["haptic"]["y"], (Json{0.5, 8000.0, 8000.0, 31.0, 31.0, 0.5}));
  EXPECT_EQ(data["jitter"]["loops"]["physics"]["x"], (Json{24.576, 24.576, 32.768, 32.768}));
  EXPECT_EQ(data["loop_faults"]["haptic_missed"], (Json{0.0, 3.0, 0.0}));
  EXPECT_FALSE(data["no_loop_faults"].get<bool>());
}

TEST_F(ReportData, HasEachTripWithItsCauseAndWhatTheHandLost) {
  write("raw/realtime_loops.csv",
        "time_s,haptic_ticks,physics_ticks,haptic_overruns,haptic_missed,physics_overruns,physics_missed\n"
        "0.5,500,500,0,0,0,0\n1.5,1500,1500,0,0,0,0\n");
  std::string rows = "time_s,tick,cause,who,away_s,returned,lost_n_s,file,outage_s,kind\n";
  for (int i = 0; i < 45; ++i)
    rows += fmt::format("{:.1f},{},{},,0.02,{},0.001,,{},{}\n", 0.1 * i, 100 * i + 1,
                        i % 3 == 0 ? "arm silent" : "late tick", i < 44 ? 1 : 0, i < 40 ? 0.021 : 0.07,
                        i < 40 ? "outage" : "trip");
  write("raw/realtime_trips.csv", rows);
  const Json data = realtime_data(play());
  const Json& trips = data["trips"];
  EXPECT_FALSE(data["no_trips"].get<bool>());
  EXPECT_EQ(trips["count"], 45);
  EXPECT_EQ(trips["outages"], 40);
  EXPECT_EQ(trips["trips"], 5);
  EXPECT_EQ(trips["causes"],
            (Json{{{"cause", "arm silent"}, {"count", 15}}, {{"cause", "late tick"}, {"count", 30}}}));
  EXPECT_NEAR(trips["lost_mn_s"].get<double>(), 45.0, 1e-9);
  EXPECT_EQ(trips["shown"].size() + trips["more"].get<std::size_t>(), 45u);
  EXPECT_NEAR(trips["shown"][3]["time_s"].get<double>(), 0.3, 1e-12);
  EXPECT_NEAR(trips["shown"][3]["away_ms"].get<double>(), 20.0, 1e-9);
}

TEST_F(ReportData, SaysSoWhereNothingWentWrong) {
  write("raw/realtime_frames.csv",
        "time_s,round_trip_us,late,lost,repeated,out_of_order\n0.5,100,0,0,0,0\n1.5,120,0,0,0,0\n");
  write("raw/realtime_loops.csv",
        "time_s,haptic_ticks,physics_ticks,haptic_overruns,haptic_missed,physics_overruns,physics_missed\n"
        "0.5,500,500,0,0,0,0\n1.5,1500,1500,0,0,0,0\n");
  const Json data = realtime_data(play());
  EXPECT_TRUE(data["no_late_answers"].get<bool>());
  EXPECT_TRUE(data["no_loop_faults"].get<bool>());
  EXPECT_FALSE(data.contains("loop_faults"));
  EXPECT_TRUE(data["no_trips"].get<bool>());
}

TEST_F(ReportData, HasThePicturesOfTheRealTimeRunOnceTheyHaveSettledAndLateOnesApart) {
  write("raw/realtime_poses.csv",
        "time_s,late,pose_source,world_px,tip_px\n0.5,0,refined,9.5,9.5\n1.5,0,refined,0.125,0.25\n"
        "2.5,1,refined,0.375,4.5\n3.5,0,refined,0.5,\n");
  const Json overlay = realtime_data(play())["realtime_overlay"];
  EXPECT_EQ(overlay["world"]["y"], (Json{0.125, 0.375, 0.5}));
  EXPECT_EQ(overlay["tip_late"]["y"], Json{4.5});
  EXPECT_EQ(overlay["tip"]["y"], Json{0.25});
}

// The cable is out from 4 s to 7 s.
TEST_F(ReportData, ListsWhatHappenedWhenTheCableWasPulled) {
  write_network();
  const Json data = network_data(play());
  EXPECT_EQ(data["plugged_at_s"], 7.0);
  std::vector<std::string> order;
  for (const auto& event : data["events"]) order.push_back(event.items().begin().key());
  EXPECT_EQ(order, (std::vector<std::string>{"pulled", "gone", "client_forgotten", "plugged", "back",
                                             "replies", "answers"}));
  EXPECT_NEAR(data["events"][1]["at_s"].get<double>(), 4.6, 1e-12);
  EXPECT_TRUE(data["events"][5]["after_plug"].get<bool>());
  EXPECT_EQ(data["phases"]["cut"]["late"], 89);
  EXPECT_TRUE(data["phases"]["before"]["late"].is_null());
  // Those without an answer stand above all others.
  const Json& timeline = data["timeline"];
  double slowest = 0.0;
  for (const auto& us : timeline["answered"]["y"]) slowest = std::max(slowest, us.get<double>());
  for (const auto& us : timeline["without"]["y"]) EXPECT_GT(us.get<double>(), slowest);
  EXPECT_NEAR(data["loops"]["haptic"]["y"][0].get<double>(), 1000.0, 1.0);
}

}  // namespace
}  // namespace palpate::tools::demo
