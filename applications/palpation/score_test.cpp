#include "applications/palpation/score.h"

#include <gtest/gtest.h>

#include <cmath>

namespace palpate::applications::palpation {
namespace {

HiddenNodule nodule_at(double x, double z) {
  HiddenNodule nodule;
  nodule.above = {x, 0.05, z};
  return nodule;
}

TEST(Score, ANodulesNearestMarkFindsItAndTheOthersAreFalseAlarms) {
  const std::vector<HiddenNodule> nodules{nodule_at(0.0, 0.0), nodule_at(0.03, 0.0)};
  const std::vector<Vector3> marks{{0.006, 0.05, 0.0}, {0.0, 0.05, 0.004}, {0.03, 0.05, 0.02}};
  const Score score = score_of(nodules, marks, 0.010);
  EXPECT_EQ(score.nodules, 2);
  EXPECT_EQ(score.found, 1);
  EXPECT_EQ(score.missed(), 1);
  EXPECT_EQ(score.false_alarms, 2);
  EXPECT_NEAR(score.error[0], 0.004, 1e-12);
  EXPECT_TRUE(std::isnan(score.error[1]));
  EXPECT_NEAR(score.median_error(), 0.004, 1e-12);
}

TEST(Score, OneMarkBetweenTwoFindsOneOnly) {
  const std::vector<HiddenNodule> nodules{nodule_at(-0.008, 0.0), nodule_at(0.009, 0.0)};
  const std::vector<Vector3> marks{{0.0, 0.05, 0.0}};
  const Score score = score_of(nodules, marks, 0.010);
  EXPECT_EQ(score.found, 1);
  EXPECT_TRUE(std::isnan(score.error[1])) << "the nearer one is found";
  EXPECT_EQ(score.false_alarms, 0);
}

// Taking pairs by their distance leaves the second mark to the second nodule.
TEST(Score, TwoMarksAreSharedOut) {
  const std::vector<HiddenNodule> nodules{nodule_at(0.0, 0.0), nodule_at(0.012, 0.0)};
  const std::vector<Vector3> marks{{0.005, 0.05, 0.0}, {0.003, 0.05, 0.0}};
  const Score score = score_of(nodules, marks, 0.010);
  EXPECT_EQ(score.found, 2);
  EXPECT_NEAR(score.median_error(), 0.5 * (0.003 + 0.007), 1e-12);
}

TEST(Score, NothingHiddenAndNothingMarked) {
  const Score score = score_of({}, {}, 0.010);
  EXPECT_EQ(score.found + score.false_alarms + score.nodules, 0);
  EXPECT_TRUE(std::isnan(score.median_error()));
}

TEST(Score, TheBoundBelongsToWhatIsFound) {
  const std::vector<HiddenNodule> nodules{nodule_at(0.0, 0.0)};
  EXPECT_EQ(score_of(nodules, std::vector<Vector3>{{0.0099, 0.05, 0.0}}, 0.010).found, 1);
  EXPECT_EQ(score_of(nodules, std::vector<Vector3>{{0.0101, 0.05, 0.0}}, 0.010).found, 0);
}

}  // namespace
}  // namespace palpate::applications::palpation
