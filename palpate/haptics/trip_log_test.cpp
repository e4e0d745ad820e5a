#include "palpate/haptics/trip_log.h"

#include <gtest/gtest.h>

#include "palpate/core/csv.h"
#include "palpate/haptics/haptic_bench_test.h"

namespace palpate::haptics {
namespace {

constexpr double kTickOfTrips = 1e-3, kAskedInTrips = 1.0;  // s, N

// Forces of 1 N are asked for; the arm stands still for `silent` ticks in each of `times` outages.
struct Interrupted {
  HapticBench bench{without_ramp()};
  TripLog log;

  explicit Interrupted(std::size_t most = 10) : log(bench.loop, most) {
    bench.message.continuous = {0.0, kAskedInTrips, 0.0};
    bench.live(300);
    log.look();
  }
  void outage(int silent, int after = 400) {
    bench.arm.frozen = true;
    bench.live(silent);
    bench.arm.frozen = false;
    bench.live(after);
  }
};

TEST(TripLog, EveryTripHasItsTimeItsCauseAndWhatTheHandLost) {
  Interrupted run;
  EXPECT_FALSE(run.log.look());
  double owed = 0.0;  // counted from the arm itself
  for (int i = 0; i < 3; ++i) {
    run.outage(60);
    EXPECT_TRUE(run.log.look());
  }
  ASSERT_EQ(run.log.trips().size(), 3u);
  EXPECT_EQ(run.bench.loop.condition().trips, 3u);
  for (const auto& trip : run.log.trips()) {
    EXPECT_EQ(trip.trip.fault, ForceFault::arm_silent);
    EXPECT_TRUE(trip.returned);
    // Told once the stamps have stood still for a while; gone with the first that moves on.
    EXPECT_GT(trip.away_s, 10 * kTickOfTrips);
    EXPECT_LT(trip.away_s, 61 * kTickOfTrips);
    owed = 0.0;
    for (std::uint64_t k = trip.trip.tick - 1; k < trip.trip.tick + 80; ++k) {
      const auto record = *run.bench.loop.record(k);
      if (record.fault == ForceFault::none) {
        EXPECT_EQ(trip.away_s, to_seconds(record.time - trip.trip.time));
        break;
      }
      if (k + 1 > trip.trip.tick) owed += kTickOfTrips * (kAskedInTrips - record.commanded.norm());
    }
    EXPECT_NEAR(trip.lost_n_s, owed, 1e-9);
    EXPECT_GT(trip.lost_n_s, 0.2 * kAskedInTrips * trip.away_s) << "forces were off for most of it";
    EXPECT_LE(trip.lost_n_s, kAskedInTrips * trip.away_s);
  }
  EXPECT_NEAR(to_seconds(run.log.trips()[1].trip.time - run.log.trips()[0].trip.time), 460 * kTickOfTrips,
              2 * kTickOfTrips);
}

// The stamps stand still for so many ticks; an outage begins 5 ms after the last that moved on.
TEST(TripLog, AnOutageIsBriefOrATripByRealTime) {
  Interrupted run;
  for (const int silent : {12, 30, 54, 57, 90, 300}) {
    run.outage(silent, 1200);
    run.log.look();
    ASSERT_FALSE(run.log.trips().empty());
    const LoggedTrip& newest = run.log.trips().back();
    EXPECT_TRUE(newest.returned);
    EXPECT_NEAR(newest.outage_s, (silent - 4) * kTickOfTrips, 1.01 * kTickOfTrips);
    EXPECT_EQ(newest.is_trip(), silent > 55) << silent;
  }
  const TripSummary summary = summary_of(run.log.trips());
  EXPECT_EQ(summary.outages, 3u);
  EXPECT_EQ(summary.trips, 3u);
  EXPECT_EQ(summary.trip_causes, (std::map<std::string, std::uint64_t>{{"arm silent", 3}}));
  EXPECT_EQ(summary.outage_causes, (std::map<std::string, std::uint64_t>{{"arm silent", 3}}));
  EXPECT_NEAR(summary.longest_outage_s, 0.296, 0.002);
}

// Between two ticks the loop itself stands still: no tick was there to count it.
TEST(TripLog, AStallOfTheLoopCountsWithTheTimeThatPassed) {
  Interrupted run;
  for (const int ms : {8, 40, 70}) {
    run.bench.now += seconds(1e-3 * ms);
    run.bench.live(1200);
    run.log.look();
    ASSERT_FALSE(run.log.trips().empty());
    EXPECT_EQ(run.log.trips().back().trip.fault, ForceFault::late_tick);
    EXPECT_NEAR(run.log.trips().back().outage_s, 1e-3 * (ms - 4), 2.01 * kTickOfTrips);
    EXPECT_EQ(run.log.trips().back().is_trip(), ms > 55);
  }
  EXPECT_EQ(run.log.trips().size(), 3u);
}

TEST(TripLog, SeveralTripsBetweenTwoLooksAreAllThere) {
  Interrupted often, seldom;
  for (int i = 0; i < 5; ++i) {
    often.outage(50);
    often.log.look();
    seldom.outage(50);
  }
  seldom.log.look();
  ASSERT_EQ(seldom.log.trips().size(), 5u);
  for (std::size_t i = 0; i < 5; ++i) {
    EXPECT_EQ(seldom.log.trips()[i].trip.tick, often.log.trips()[i].trip.tick);
    EXPECT_EQ(seldom.log.trips()[i].away_s, often.log.trips()[i].away_s);
    EXPECT_EQ(seldom.log.trips()[i].lost_n_s, often.log.trips()[i].lost_n_s);
  }
}

TEST(TripLog, AnEndIsToldOnce) {
  Interrupted run;
  run.outage(50, 0);
  EXPECT_TRUE(run.log.look());
  EXPECT_FALSE(run.log.trips().at(0).returned);
  const double so_far = run.log.trips().at(0).away_s;
  EXPECT_FALSE(run.log.look());
  run.bench.live(400);
  EXPECT_TRUE(run.log.look());
  EXPECT_TRUE(run.log.trips().at(0).returned);
  EXPECT_NEAR(run.log.trips().at(0).away_s, so_far + kTickOfTrips, 1e-9);
  EXPECT_FALSE(run.log.look());
}

// An arm that ran away and stands still again: nothing is wrong any more, but somebody has to rearm.
TEST(TripLog, ForcesAreBackOnceSomebodyHasRearmed) {
  Interrupted run;
  double& joint = run.bench.arm.sample.joints[0];
  for (int i = 0; i < 20; ++i) {
    joint += 0.02;  // rad a tick: 6 m/s
    run.bench.live();
  }
  run.bench.live(200);
  run.log.look();
  ASSERT_EQ(run.log.trips().size(), 1u);
  EXPECT_EQ(run.log.trips()[0].trip.fault, ForceFault::overspeed);
  EXPECT_FALSE(run.log.trips()[0].returned);
  EXPECT_TRUE(run.log.trips()[0].is_trip());
  EXPECT_GT(run.log.trips()[0].away_s, 200 * kTickOfTrips);
  ASSERT_TRUE(run.bench.loop.rearm());
  run.bench.live(5);
  EXPECT_TRUE(run.log.look());
  EXPECT_TRUE(run.log.trips()[0].returned);
}

TEST(TripLog, WhatTheRingHasOverwrittenOrIsTooMuchIsCounted) {
  Interrupted seldom(1000), few(3);
  for (int i = 0; i < 300; ++i) {
    seldom.outage(30, 30);
    if (i < 5) {
      few.outage(30, 30);
      few.log.look();
    }
  }
  seldom.log.look();
  EXPECT_EQ(seldom.bench.loop.trip_count(), 300u);
  EXPECT_EQ(seldom.log.trips().size(), 256u);  // what HapticLoop keeps
  EXPECT_EQ(seldom.log.left_out(), 44u);
  EXPECT_EQ(few.log.trips().size(), 3u);
  EXPECT_EQ(few.log.left_out(), 2u);
  EXPECT_TRUE(few.log.trips()[2].returned);
}

TEST(TripLog, WhatDoesNotReturnIsSaidAndTheTableIsReadByOthers) {
  Interrupted run;
  run.outage(50);
  run.bench.arm.sample.connected = false;
  run.bench.live(50);
  run.log.look();
  run.log.set_file(run.log.trips()[0].trip.tick, "trip_1.csv");
  const Instant<PhysicsClock> begun{std::chrono::milliseconds(100)};
  CsvOptions options;
  options.text_columns = {"cause", "who", "file", "kind"};
  const auto table =
      parse_csv(trips_csv(run.log.trips(), begun, run.bench.loop), "realtime_trips.csv", options);
  ASSERT_TRUE(table) << table.error().message;
  ASSERT_EQ(table->rows.size(), 2u);
  EXPECT_EQ(table->text[0][2], "arm silent");
  EXPECT_EQ(table->rows[0][5], 1.0);
  EXPECT_EQ(table->text[0][7], "trip_1.csv");
  EXPECT_EQ(table->text[0][9], "outage");
  EXPECT_EQ(table->text[1][2], "arm lost");
  EXPECT_EQ(table->text[1][9], "trip");
  EXPECT_EQ(table->rows[1][5], 0.0);
  EXPECT_EQ(table->text[1][7], "");
  EXPECT_NEAR(table->rows[0][6], run.log.trips()[0].lost_n_s, 1e-6);
  EXPECT_NEAR(table->rows[1][0], run.log.trips()[1].trip.time.seconds() - 0.1, 1e-4);
}

}  // namespace
}  // namespace palpate::haptics
