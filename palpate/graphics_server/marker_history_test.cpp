#include "palpate/graphics_server/marker_history.h"

#include <gtest/gtest.h>

namespace palpate {
namespace {

Instant<GraphicsClock> at(double s) { return Instant<GraphicsClock>::from_seconds(s); }

MarkerPose pose(double time, double x) {
  MarkerPose p;
  p.time = at(time);
  p.translation = {x, 0, 0};
  p.rotation = so3_exp({0, 0, x});
  return p;
}

TEST(MarkerHistory, InterpolatesBetweenNeighbours) {
  MarkerHistory history;
  history.add(pose(1.00, 0.0));
  history.add(pose(1.01, 0.1));
  const auto p = history.at(at(1.0025));
  ASSERT_TRUE(p.has_value());
  EXPECT_NEAR(p->translation.x(), 0.025, 1e-12);
  EXPECT_NEAR(so3_log(p->rotation).z(), 0.025, 1e-12);
}

TEST(MarkerHistory, GivesNothingOutsideWhatWasSeenOrAcrossAGap) {
  MarkerHistory history;
  EXPECT_FALSE(history.at(at(1.0)).has_value());
  history.add(pose(1.0, 0));
  history.add(pose(1.2, 0));
  EXPECT_FALSE(history.at(at(0.9)).has_value());
  EXPECT_FALSE(history.at(at(1.1)).has_value());
  EXPECT_FALSE(history.at(at(1.3)).has_value());
  EXPECT_TRUE(history.at(at(1.2)).has_value());
}

TEST(MarkerHistory, IgnoresLateAndRepeatedSamples) {
  MarkerHistory history;
  history.add(pose(1.00, 0));
  history.add(pose(1.01, 1));
  history.add(pose(1.005, 50));
  history.add(pose(1.01, 50));
  EXPECT_NEAR(history.at(at(1.005))->translation.x(), 0.5, 1e-12);
}

}  // namespace
}  // namespace palpate
