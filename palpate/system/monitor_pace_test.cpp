#include "palpate/system/monitor_pace.h"

#include <gtest/gtest.h>

#include <vector>

namespace palpate {
namespace {

using std::chrono::milliseconds;

struct Course {
  std::vector<Instant<GraphicsClock>> drawn;  // when each picture for onlookers was begun
  Duration late{0};                           // by which the player's images waited for one, all in all
  Duration took{0}, lasted{0};                // drawing for onlookers; the whole course
};

// A frame loop: an image each `period`, which takes `frame`; then, where it is time, a picture for onlookers,
// which takes `cost`.
Course course(Duration period, Duration frame, Duration cost, int images = 600) {
  Course result;
  MonitorPace pace;
  Instant<GraphicsClock> free{};
  for (int i = 0; i < images; ++i) {
    const Instant<GraphicsClock> arrived = Instant<GraphicsClock>{} + i * period;
    const auto begun = std::max(arrived, free);
    const bool waited_for_onlookers =
        free > arrived && !result.drawn.empty() && free == result.drawn.back() + cost;
    if (waited_for_onlookers) result.late += free - arrived;
    free = begun + frame;
    if (pace.due(begun, free)) {
      result.drawn.push_back(free);
      pace.drew(free, cost);
      free = free + cost;
      result.took += cost;
    }
  }
  result.lasted = free - Instant<GraphicsClock>{};
  return result;
}

Duration shortest_gap(const Course& c) {
  Duration shortest = std::chrono::hours(1);
  for (std::size_t i = 1; i < c.drawn.size(); ++i) shortest = std::min(shortest, c.drawn[i] - c.drawn[i - 1]);
  return shortest;
}

TEST(MonitorPace, DrawsFifteenTimesASecondBesideACameraOfThirtyAndDelaysNothing) {
  const Course c = course(milliseconds(33), milliseconds(15), milliseconds(10));
  EXPECT_EQ(c.drawn.size(), 300u);  // every second one
  EXPECT_EQ(c.late, Duration{0});
}

TEST(MonitorPace, NeverDrawsMoreThan25TimesASecondHoweverFastTheCamera) {
  const Course c = course(milliseconds(7), milliseconds(1), milliseconds(1));
  EXPECT_GE(shortest_gap(c), MonitorPace::kShortest);
  EXPECT_GT(c.drawn.size(), 80u);  // 4.2 s
  EXPECT_EQ(c.late, Duration{0});
}

TEST(MonitorPace, WhereNoTimeIsLeftItComesNowAndThen) {
  // 21 ms to spare and 30 needed.
  const Course c = course(milliseconds(33), milliseconds(12), milliseconds(30));
  EXPECT_GE(shortest_gap(c), MonitorPace::kOverdue);
  EXPECT_GT(c.drawn.size(), 80u);  // 19.8 s, about five a second
  // Each makes one image wait, by what it is too long.
  EXPECT_LE(c.late, static_cast<int>(c.drawn.size()) * milliseconds(9));
}

TEST(MonitorPace, TakesASixthOfTheTimeAtMostHoweverSlowTheMachine) {
  for (const int cost_ms : {60, 100, 400}) {
    const Course c = course(milliseconds(33), milliseconds(40), milliseconds(cost_ms));
    EXPECT_LE(to_seconds(c.took), to_seconds(c.lasted) / MonitorPace::kShare * 1.05) << cost_ms;
    EXPECT_GT(c.drawn.size(), 5u);
  }
}

TEST(MonitorPace, ALongOneCountsAtOnceAndIsForgottenByAndBy) {
  MonitorPace pace;
  Instant<GraphicsClock> now{};
  const auto next = [&] { return now = now + milliseconds(50); };
  EXPECT_TRUE(pace.due(next(), now));
  pace.drew(now, milliseconds(5));
  EXPECT_TRUE(pace.due(next(), now));
  pace.drew(now, milliseconds(120));  // the machine stood still
  EXPECT_FALSE(pace.due(next(), now));
  // Overdue after six times as long: then it is quick again, and eight later all is as before.
  int drawn = 0;
  for (int i = 0; i < 200; ++i)
    if (pace.due(next(), now)) {
      pace.drew(now, milliseconds(5));
      ++drawn;
    }
  EXPECT_GT(drawn, 120);
}

}  // namespace
}  // namespace palpate
