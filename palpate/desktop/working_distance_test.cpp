#include "palpate/desktop/working_distance.h"

#include <gtest/gtest.h>

namespace palpate::desktop {
namespace {

Instant<GraphicsClock> after(double s) { return Instant<GraphicsClock>::from_seconds(s); }

TEST(WorkingDistance, BeginsWhereTheTipIs) {
  WorkingDistance distance;
  EXPECT_EQ(distance.distance(), WorkingDistance::kFirst);
  EXPECT_EQ(distance.look({{0.1, 0.1, 0.45}}, after(3.0)), 0.45);
}

TEST(WorkingDistance, FollowsTheTipSlowlyAndAtTheSamePaceAtAnyRate) {
  for (const double rate : {10.0, 60.0}) {
    WorkingDistance distance;
    distance.look({{0.0, 0.0, 0.4}}, after(0.0));
    double last = 0.0;
    for (int i = 1; i <= static_cast<int>(rate * WorkingDistance::kSmooth_s); ++i)
      last = distance.look({{0.0, 0.0, 0.8}}, after(i / rate));
    // A first-order lag: after its time 1/e of the step is left.
    EXPECT_NEAR(last, 0.8 - 0.4 * std::exp(-1.0), 1e-9) << rate;
  }
}

TEST(WorkingDistance, StaysWhereAPictureCanStand) {
  WorkingDistance distance;
  EXPECT_EQ(distance.look({{0.0, 0.0, 0.01}}, after(0.0)), WorkingDistance::kNearest);
  EXPECT_EQ(distance.look({{0.0, 0.0, -0.5}}, after(1.0)), WorkingDistance::kNearest) << "behind the camera";
  EXPECT_LE(distance.look({{0.0, 0.0, 40.0}}, after(100.0)), WorkingDistance::kFarthest);
}

}  // namespace
}  // namespace palpate::desktop
