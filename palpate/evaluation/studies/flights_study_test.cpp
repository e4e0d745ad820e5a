#include "palpate/evaluation/studies/flights_study.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "palpate/core/csv.h"
#include "palpate/core/file.h"
#include "palpate/math/random_vector.h"
#include "tests/scratch_folder.h"

namespace palpate::evaluation::studies {
namespace {

FlightsOptions recorded(const std::string& folder, int threads = 1) {
  FlightsOptions options;
  options.data = std::string(PALPATE_DATA_DIR) + "/" + folder;
  options.repeats.threads = threads;
  return options;
}

double median_at(const Json& mode, int horizon) {
  for (const auto& h : mode.at("horizons"))
    if (h.at("horizon_ms") == horizon) return h.at("median_mm").get<double>();
  return kNoValue;
}

TEST(FlightsStudy, AirIsWorthManyTimesTheError) {
  const auto study = study_flights(recorded("flights"));
  ASSERT_TRUE(study) << study.error().message;
  const auto& v = study->values;
  EXPECT_EQ(v["flights"], 12);
  // Half of a campaign whose medians are known from another program: 6.2 / 16.6 / 15.8 mm and, without
  // air, 13.6 / 76.8 / 188.8 mm. Eight flights of it: within 40 %.
  const auto& full = v["full"]["sets"]["no_spin_robot_simple"];
  const auto& paper = v["paper"]["sets"]["no_spin_robot_simple"];
  const std::array<double, 3> expected_full{6.2, 16.6, 15.8}, expected_paper{13.6, 76.8, 188.8};
  for (std::size_t h = 0; h < 3; ++h) {
    EXPECT_LT(median_at(full, kKeyHorizons_ms[h]), 1.40 * expected_full[h]);
    EXPECT_NEAR(median_at(paper, kKeyHorizons_ms[h]) / expected_paper[h], 1.0, 0.40);
  }
  for (const char* set : {"mn5008_topspin", "mn5008_backspin"})
    EXPECT_LT(median_at(v["full_with_fitted_spin"]["sets"][set], 300),
              0.5 * median_at(v["full"]["sets"][set], 300))
        << "knowing a strong spin is worth much";
  const auto& bounces = v["bounces"]["no_spin_robot_simple"];
  EXPECT_EQ(bounces["bounces"], 8);
  EXPECT_NEAR(bounces["table_height_m"].get<double>(), 0.760, 0.003);
  EXPECT_NEAR(bounces["restitution"]["median"].get<double>(), 0.93, 0.02);
}

// The same error once more, by other means: a horizon's error is what fit and simulation say by themselves.
TEST(FlightsStudy, AnErrorIsTheDistanceToThePlaceSeenThen) {
  // A ball without air, without noise: the paper's mode is exact, and the full mode off by its drag.
  RecordedFlight flight{"thrown_1", "thrown", {}, {}};
  for (int i = 0; i < 180; ++i) {
    const double t = i / 200.0;
    flight.seen.push_back({t, {4.0 * t, 0.0, 5.0 + 2.0 * t - 0.5 * 9.81 * t * t}});
  }
  const auto paper = tell_flight(flight, kFlightModes[0], {}),
             full = tell_flight(flight, kFlightModes[1], {});
  ASSERT_TRUE(paper && full);
  for (std::size_t h = 0; h < kHorizons; ++h) EXPECT_NEAR(paper->error_mm[h], 0.0, 1e-6) << h;
  // After s seconds drag has carried the ball back by about k v^2 s^2 / 2.
  const double s = 0.3, v2 = 16.0;
  EXPECT_NEAR(full->error_mm[300 / kHorizonStep_ms - 1], 1e3 * 0.5 * 0.09 * v2 * s * (s + 0.1), 25.0);
  flight.seen.resize(80);  // 0.395 s: the horizon of 300 ms was not seen
  const auto shorter = tell_flight(flight, kFlightModes[0], {});
  EXPECT_TRUE(std::isfinite(shorter->error_mm[275 / kHorizonStep_ms - 1]));
  EXPECT_TRUE(std::isnan(shorter->error_mm[325 / kHorizonStep_ms - 1]));
}

TEST(FlightsStudy, WhatComesAfterAnImpactIsNotPredicted) {
  const auto flights = read_flights(recorded("robot_returns"));
  ASSERT_TRUE(flights) << flights.error().message;
  ASSERT_EQ(flights->size(), 3u);
  const auto table = table_of(*flights, "robot_return");
  EXPECT_NEAR(table.height, 0.782, 0.008);
  for (const auto& flight : *flights) {
    const auto impact =
        std::find_if(flight.jumps.begin(), flight.jumps.end(), [](const physics::VelocityJump& jump) {
          return !physics::bounced_on_resting_surface(jump, Vector3::UnitZ());
        });
    ASSERT_NE(impact, flight.jumps.end());
    auto early = flight;  // the recording cut at the impact tells the same errors, and no more
    std::erase_if(early.seen, [&](const physics::SeenBall& ball) { return ball.time > impact->time; });
    early.jumps.erase(early.jumps.begin() + (impact - flight.jumps.begin()), early.jumps.end());
    for (const auto& mode : kFlightModes) {
      const auto whole = tell_flight(flight, mode, table), cut = tell_flight(early, mode, table);
      ASSERT_TRUE(whole && cut);
      for (std::size_t h = 0; h < kHorizons; ++h) {
        EXPECT_EQ(std::isnan(whole->error_mm[h]), std::isnan(cut->error_mm[h]));
        if (!std::isfinite(cut->error_mm[h])) continue;
        EXPECT_DOUBLE_EQ(whole->error_mm[h], cut->error_mm[h]);
      }
    }
  }
  const auto study = study_flights(recorded("robot_returns"));
  ASSERT_TRUE(study) << study.error().message;
  EXPECT_GE(study->values["bounces"]["robot_return"]["blows"], 3);
  EXPECT_GE(study->values["bounces"]["robot_return"]["bounces"], 5);
  EXPECT_NEAR(study->values["bounces"]["robot_return"]["restitution"]["median"].get<double>(), 0.92, 0.05);
}

TEST(FlightsStudy, TheSameNumbersOnOneThreadAndOnTwo) {
  const auto one = study_flights(recorded("flights", 1)), two = study_flights(recorded("flights", 2));
  ASSERT_TRUE(one && two);
  EXPECT_EQ(one->values.dump(), two->values.dump());
  EXPECT_EQ(curves_csv(one->curves), curves_csv(two->curves));
}

TEST(FlightsStudy, FilesAndPageAreWritten) {
  const ScratchFolder folder;
  const auto study = study_flights(recorded("flights"));
  ASSERT_TRUE(study);
  ASSERT_TRUE(can_be_written(folder / "out"));
  ASSERT_TRUE(write_study(*study, {}, folder / "out"));
  const auto done =
      write_study_report("flights", {{"flights", 12}, {"data", "here"}}, {*study}, folder / "out");
  ASSERT_TRUE(done) << done.error().message;
  const auto html = read_file(folder / "out" / "report.html");
  ASSERT_TRUE(html);
  for (const char* told : {"no_spin_robot_simple", "mn5008_topspin", "Restitution of every bounce",
                           "data-name=\"no_spin_robot_simple\""})
    EXPECT_NE(html->find(told), std::string::npos) << told;
  const auto errors = read_csv(folder / "out" / "errors.csv", {.text_columns = {"*"}});
  ASSERT_TRUE(errors) << errors.error().message;
  EXPECT_EQ(errors->rows.size(), 12u * kFlightModes.size());
  const auto json = read_file(folder / "out" / "flights.json");
  ASSERT_TRUE(json);
  EXPECT_EQ(Json::parse(*json)["values"]["full"], study->values["full"]);
}

TEST(FlightsStudy, FoldersWithoutFlightsAreRefused) {
  const ScratchFolder folder;
  const auto complaint = [&](const std::string& below, int exit_code) {
    FlightsOptions options;
    options.data = folder / below;
    const auto study = study_flights(options);
    if (study) return std::string("none");
    EXPECT_EQ(study.error().exit_code(), exit_code);
    EXPECT_EQ(study.error().message.find('\n'), std::string::npos);
    return study.error().message;
  };
  EXPECT_NE(complaint("nowhere", 2).find("nowhere is not a folder; --data expects"), std::string::npos);
  ASSERT_TRUE(make_folder(folder / "empty"));
  EXPECT_NE(complaint("empty", 2).find("holds no *.csv flight"), std::string::npos);
  ASSERT_TRUE(make_folder(folder / "bad"));
  ASSERT_TRUE(write_file(folder / "bad" / "one.csv", "t_s,x_m,y_m,z_m\n0,0,0,1\n0.1,0,nan,1\n"));
  EXPECT_NE(complaint("bad", 2).find("one.csv:3"), std::string::npos);
  ASSERT_TRUE(make_folder(folder / "short"));
  ASSERT_TRUE(
      write_file(folder / "short" / "s.csv",
                 "t_s,x_m,y_m,z_m\n0,0,0,1\n0.01,0,0,1\n0.02,0,0,1\n0.03,0,0,1\n0.04,0,0,1\n0.05,0,0,1\n"
                 "0.06,0,0,1\n"));
  EXPECT_NE(complaint("short", 1).find("no flight in"), std::string::npos);
}

}  // namespace
}  // namespace palpate::evaluation::studies
