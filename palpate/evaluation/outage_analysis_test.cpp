#include "palpate/evaluation/outage_analysis.h"

#include <gtest/gtest.h>

namespace palpate::evaluation {
namespace {

// Ten seconds at 10 pictures and 10 looks a second; the cable is out from 4 to 7. The client is gone from 4.6
// to 7.3, answers stop at 4 and are there again from 7.35.
NetworkRecords ten_seconds() {
  NetworkRecords records{.encrypted = true,
                         .physics_address = "tcp://there:1",
                         .graphics_place = "here",
                         .pulled_s = 4.0,
                         .plugged_s = 7.0,
                         .server_there = {{4.6, false}, {7.3, true}}};
  CsvWriter frames({"time_s", "round_trip_us", "late", "unsent", "lost", "repeated", "out_of_order"});
  CsvWriter sync({"time_s", "offset_error_us", "uncertainty_us"});
  CsvWriter loops({"time_s", "clients", "requests", "haptic_ticks", "haptic_overruns", "haptic_missed",
                   "physics_ticks", "physics_overruns", "physics_missed"});
  double requests = 0.0;
  for (int i = -10; i < 100; ++i) {
    const double t = 0.1 * i + 0.05;
    const bool answered = t < 4.0 || t > 7.3;
    requests += answered ? 1.0 : 0.0;
    const int overruns = t < 2.0 ? 0 : (t < 5.0 ? 3 : 4);
    loops.row({t, t > 5.0 && t < 7.3 ? 0.0 : 1.0, requests, 100.0 * (i + 10), double(overruns), 0.0,
               100.0 * (i + 10), 0.0, 0.0});
    if (t < 0.0) continue;  // the physics server was there before
    frames.row(std::vector<std::string>{number_text(t), answered ? "500" : "", answered ? "0" : "1",
                                        t > 5.0 ? "7" : "0", t > 5.0 ? "4" : "0", "0", "0"});
    sync.row({t, t > 6.0 && t < 6.2 ? -60.0 : 10.0, t > 4.0 && t < 7.0 ? 50.0 : 20.0});
  }
  CsvOptions text;
  text.text_columns = {"*"};
  records.frames = parse_csv(frames.content(), "frames", text).value();
  records.sync = parse_csv(sync.content(), "sync", text).value();
  records.loops = parse_csv(loops.content(), "loops", text).value();
  return records;
}

TEST(NetworkStory, TellsWhenEachSideNoticedAndWhenItWasBack) {
  const Json story = outage_analysis(ten_seconds()).value();
  EXPECT_NEAR(story["cut_for_s"].get<double>(), 3.0, 1e-9);
  EXPECT_NEAR(story["gone_after_s"].get<double>(), 0.6, 1e-9);
  EXPECT_NEAR(story["back_after_s"].get<double>(), 0.3, 1e-9);
  EXPECT_NEAR(story["replies_after_s"].get<double>(), 0.35, 1e-9);
  EXPECT_NEAR(story["client_forgotten_after_s"].get<double>(), 1.05, 1e-9);
  EXPECT_NEAR(story["answers_after_s"].get<double>(), 0.35, 1e-9);
  EXPECT_EQ(story["unsent"], 7);
  EXPECT_EQ(story["lost"], 4);
}

TEST(NetworkStory, CountsBeforeDuringAndAfter) {
  const Json story = outage_analysis(ten_seconds()).value();
  EXPECT_EQ(story["before"]["frames"], 40);
  EXPECT_EQ(story["cut"]["frames"], 30);
  EXPECT_EQ(story["after"]["frames"], 30);
  EXPECT_EQ(story["before"]["late"], 0);
  EXPECT_EQ(story["cut"]["late"], 30);
  EXPECT_EQ(story["after"]["late"], 3);
  EXPECT_EQ(story["before"]["haptic_ticks"], 4000);
  EXPECT_EQ(story["cut"]["haptic_ticks"], 3000);
  EXPECT_EQ(story["after"]["haptic_ticks"], 3000);
  EXPECT_EQ(story["before"]["haptic_overruns"], 3);
  EXPECT_EQ(story["cut"]["haptic_overruns"], 1);
  EXPECT_EQ(story["after"]["haptic_overruns"], 0);
  EXPECT_EQ(story["cut"]["clock_error_us_max"], 60.0);
  EXPECT_EQ(story["cut"]["clock_uncertainty_us_max"], 50.0);
  EXPECT_NEAR(story["cut"]["clock_inside_share"].get<double>(), 28.0 / 30.0, 1e-12);
  EXPECT_EQ(story["after"]["clock_inside_share"], 1.0);
}

TEST(NetworkStory, LeavesOutWhatNeverCame) {
  auto records = ten_seconds();
  records.server_there.clear();
  records.frames.rows.resize(60);  // the run ended while the cable was out
  const Json story = outage_analysis(records).value();
  EXPECT_FALSE(story.contains("gone_after_s"));
  EXPECT_FALSE(story.contains("back_after_s"));
  EXPECT_FALSE(story.contains("replies_after_s"));
}

TEST(NetworkStory, RefusesATableWithoutItsColumns) {
  auto records = ten_seconds();
  records.loops.header.front() = "when";
  EXPECT_FALSE(outage_analysis(records).has_value());
}

TEST(NetworkStory, ListsEventsInTheirOrder) {
  EXPECT_EQ(
      network_events(ten_seconds()),
      "time_s,event\n4,cable pulled\n4.6,physics server gone\n7,cable plugged in\n7.3,physics server back\n");
}

}  // namespace
}  // namespace palpate::evaluation
