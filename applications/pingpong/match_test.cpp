// When a match is over, what a return is worth, and which level comes next.
#include "applications/pingpong/match.h"

#include <gtest/gtest.h>

namespace palpate::applications::pingpong {
namespace {

// Plays a match's serves, of which so many come back, each `rally` times.
void play(Match& match, int serves, int returned, int rally = 1) {
  for (int i = 0; i < serves; ++i) {
    match.serve();
    for (int k = 0; i < returned && k < rally; ++k) match.bring_back(k == 0);
    match.end_serve();
  }
}

TEST(Match, IsOverAfterItsServesAndCountsReturnsTimesTheLevel) {
  Match match({.serves = 10, .level = 2});
  play(match, 9, 4, 3);
  EXPECT_FALSE(match.over());
  EXPECT_EQ(match.points(), 4 * 3 * 2);
  EXPECT_EQ(match.returned(), 4);
  EXPECT_EQ(match.best(), 0) << "of a match that is over";
  play(match, 1, 0);
  EXPECT_TRUE(match.over());
  EXPECT_EQ(match.best(), 24);
}

TEST(Match, OneThatIsWonLeadsToTheNextLevelUpToTheLast) {
  Match match({.serves = 10, .level = 4});
  play(match, 10, 6);
  EXPECT_FALSE(match.won());
  match.begin_next();
  EXPECT_EQ(match.level(), 4);
  EXPECT_FALSE(match.over());
  EXPECT_EQ(match.serves() + match.returned() + match.points(), 0);
  for (int i = 0; i < 3; ++i) {
    play(match, 10, 7);
    EXPECT_TRUE(match.won());
    match.begin_next();
    EXPECT_EQ(match.level(), kLevels);
  }
  EXPECT_EQ(match.best(), 7 * kLevels);
}

TEST(Match, WithoutAnEndIsNeverOver) {
  Match match;
  play(match, 1000, 1000);
  EXPECT_FALSE(match.has_end() || match.over());
}

TEST(Match, EachLevelServesFasterAndWider) {
  for (int level = 1; level < kLevels; ++level) {
    const LevelServes easy = serves_of_level(level), hard = serves_of_level(level + 1);
    EXPECT_LT(easy.speed[1], hard.speed[1]);
    EXPECT_LE(easy.speed[0], hard.speed[0]);
    EXPECT_LT(easy.aim_sd, hard.aim_sd);
  }
}

}  // namespace
}  // namespace palpate::applications::pingpong
