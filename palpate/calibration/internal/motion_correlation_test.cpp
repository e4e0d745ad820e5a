#include "palpate/calibration/internal/motion_correlation.h"

#include <gtest/gtest.h>

#include <cmath>

#include "palpate/math/random_vector.h"

namespace palpate::calibration {
namespace {

// Turns about changing axes, 50 Hz, from `start`.
std::vector<device::StampedPose> stream(double start, int count) {
  std::vector<device::StampedPose> poses;
  for (int i = 0; i < count; ++i) {
    const double t = 0.02 * i;
    device::StampedPose pose;
    pose.time_s = start + t;
    pose.rotation = so3_exp(Vector3(std::sin(t), 0.5 * std::sin(1.7 * t), 0.3 * std::cos(2.3 * t)));
    poses.push_back(pose);
  }
  return poses;
}

TEST(MotionCorrelation, FindsTheDelayOfTwoStreamsThatTurnAlike) {
  const auto best = delay_candidates(stream(10.0, 500), stream(7.5, 500));
  ASSERT_FALSE(best.empty());
  EXPECT_NEAR(best.front().delay_s, 2.5, 0.01);  // half a grid step
}

// The delay is that which brings the later stream's times to the earlier one's, whichever that is; fractions of a
// step are read off the peak, or lost with half a step.
TEST(MotionCorrelation, FindsItEitherWayBetweenStepsAndThroughNoise) {
  Random random(1, "motion correlation");
  for (const double delay : {-3.3, -0.013, 0.0, 0.007, 1.49}) {
    auto hand = stream(100.0, 500), eye = stream(100.0 - delay, 500);
    for (auto* poses : {&hand, &eye})
      for (auto& pose : *poses) pose.rotation = so3_exp(normal3(random, 0.002)) * pose.rotation;
    const auto best = delay_candidates(hand, eye);
    ASSERT_FALSE(best.empty()) << delay;
    EXPECT_NEAR(best.front().delay_s, delay, 0.01) << delay;
  }
}

// Seconds since 1970 with one row stamped 0: the grid over 47 years must not be one of 20 ms.
TEST(MotionCorrelation, OneWrongTimeStampDoesNotFillTheMemory) {
  auto hand = stream(1.5e9, 500);
  hand.insert(hand.begin(), device::StampedPose{});
  EXPECT_NO_THROW(delay_candidates(hand, stream(1.5e9, 500)));
  hand.front().time_s = -1e11;
  EXPECT_NO_THROW(delay_candidates(hand, stream(1.5e9, 500)));
}

}  // namespace
}  // namespace palpate::calibration
