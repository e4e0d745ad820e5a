#include "palpate/desktop/spectator_pace.h"

#include <gtest/gtest.h>

#include <vector>

namespace palpate::desktop {
namespace {

using std::chrono::milliseconds;

struct Course {
  std::vector<Instant<GraphicsClock>> drawn;  // when each picture for onlookers was begun
  Duration late{0};                           // by which the player's images waited for one, all in all
  Duration took{0}, lasted{0};                // drawing for onlookers; the whole course
};

// A frame loop: an image each `period`, the newest is taken and drawn in `frame`; then, where it is time, a
// picture for onlookers, which takes `cost`.
Course course(Duration period, Duration frame, Duration cost, Duration lasts = std::chrono::seconds(20)) {
  Course result;
  SpectatorPace pace;
  const Instant<GraphicsClock> start{};
  Instant<GraphicsClock> free = start, next = start;
  bool for_onlookers = false;  // what it did last
  while (free < start + lasts) {
    while (next + period <= free) next = next + period;  // older images are dropped
    if (for_onlookers && free > next) result.late += free - next;
    const auto begun = std::max(next, free);
    next = next + period;
    free = begun + frame;
    for_onlookers = pace.due(begun, free);
    if (!for_onlookers) continue;
    result.drawn.push_back(free);
    pace.drew(free, cost);
    free = free + cost;
    result.took += cost;
  }
  result.lasted = free - start;
  return result;
}

Duration shortest_gap(const Course& c) {
  Duration shortest = std::chrono::hours(1);
  for (std::size_t i = 1; i < c.drawn.size(); ++i) shortest = std::min(shortest, c.drawn[i] - c.drawn[i - 1]);
  return shortest;
}

TEST(SpectatorPace, DrawsFifteenTimesASecondBesideACameraOfThirtyAndDelaysNothing) {
  const Course c = course(milliseconds(33), milliseconds(15), milliseconds(10));
  EXPECT_NEAR(static_cast<double>(c.drawn.size()), 20.0 / 0.066, 5.0);  // every second one
  EXPECT_EQ(c.late, Duration{0});
}

TEST(SpectatorPace, NeverDrawsMoreThan25TimesASecondHoweverFastTheCamera) {
  const Course c = course(milliseconds(7), milliseconds(1), milliseconds(1));
  EXPECT_GE(shortest_gap(c), SpectatorPace::kShortest);
  EXPECT_GT(c.drawn.size(), 400u);  // 20 s
  EXPECT_EQ(c.late, Duration{0});
}

TEST(SpectatorPace, WhereNoTimeIsLeftItComesNowAndThen) {
  // 21 ms to spare and 30 needed.
  const Course c = course(milliseconds(33), milliseconds(12), milliseconds(30));
  EXPECT_GE(shortest_gap(c), SpectatorPace::kOverdue);
  EXPECT_GT(c.drawn.size(), 80u);  // 20 s, about five a second
  // Each makes one image wait, by what it is too long.
  EXPECT_LE(c.late, static_cast<int>(c.drawn.size()) * milliseconds(9));
}

TEST(SpectatorPace, TakesASixthOfTheTimeAtMostHoweverSlowTheMachine) {
  for (const int cost_ms : {60, 100, 400}) {
    const Course c = course(milliseconds(33), milliseconds(40), milliseconds(cost_ms));
    // The first comes at once.
    EXPECT_LE(to_seconds(c.took), to_seconds(c.lasted) / SpectatorPace::kShare + 1e-3 * cost_ms) << cost_ms;
    EXPECT_GT(c.drawn.size(), 6u);
  }
}

TEST(SpectatorPace, ALongOneCountsAtOnceAndIsForgottenByAndBy) {
  SpectatorPace pace;
  Instant<GraphicsClock> now{};
  const auto due = [&] {
    now = now + milliseconds(50);
    return pace.due(now, now);
  };
  EXPECT_TRUE(due());
  pace.drew(now, milliseconds(5));
  EXPECT_FALSE(due());  // the beat is not known before two of the player's have come undisturbed
  EXPECT_TRUE(due());
  pace.drew(now, milliseconds(120));  // the machine stood still
  EXPECT_FALSE(due());
  // It comes when overdue, after 720 and 375 ms; then it is taken for quick again, and drawn beside each.
  int drawn = 0, last_fifty = 0;
  for (int i = 0; i < 200; ++i)
    if (due()) {
      pace.drew(now, milliseconds(5));
      ++drawn;
      last_fifty += i >= 150;
    }
  EXPECT_LT(drawn, 200 - 19);
  EXPECT_EQ(last_fifty, 50);
}

}  // namespace
}  // namespace palpate::desktop
