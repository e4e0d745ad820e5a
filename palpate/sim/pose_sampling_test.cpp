#include "palpate/sim/pose_sampling.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "palpate/sim/simulated_arm.h"

namespace palpate::sim {
namespace {

TEST(PoseSampling, AMarkerIsTiltedUniformlyOverTheCapAndNoFurther) {
  Random random(1, "test");
  const Vector3 normal = Vector3(0.1, 0.9, 0.3).normalized(), towards = Vector3(-0.2, 0.5, -1.0).normalized();
  double mean = 0.0, least = 1.0;
  constexpr int kDraws = 5000;
  for (int i = 0; i < kDraws; ++i) {
    const double cosine = (random_orientation(normal, towards, kAnyRoll, random) * normal).dot(towards);
    mean += cosine / kDraws;
    least = std::min(least, cosine);
  }
  const double end = std::cos(kMarkerTilt);
  EXPECT_GE(least, end - 1e-12);
  EXPECT_LT(least, end + 0.005);
  // The cosine is uniform between its ends: its mean has an sd of (1 - end) / sqrt(12 * 5000) = 0.001.
  EXPECT_NEAR(mean, 0.5 * (1.0 + end), 0.005);
}

TEST(PoseSampling, WithoutTiltTheMarkerFacesTheTracker) {
  const Vector3 normal = Vector3::UnitX(), towards = Vector3(0.0, 0.6, 0.8);
  EXPECT_LT((facing(normal, towards) * normal - towards).norm(), 1e-12);
}

TEST(PoseSampling, ThePullHasLengthOneAndGoesDownWithTheStylus) {
  const Vector3 pull = pull_direction(Quaternion::Identity());
  EXPECT_NEAR(pull.norm(), 1.0, 1e-12);
  EXPECT_GT(pull.z(), 0.5);
  EXPECT_LT(pull.y(), 0.0);
  EXPECT_EQ(pull.x(), 0.0);
}

TEST(PoseSampling, PosesAreWithinTheRangeAndNeverFoldedUp) {
  const auto& world = config::reference_world();
  Random random(2, "test");
  double furthest = 0.0;
  for (int i = 0; i < 1000; ++i) {
    const auto theta = random_joints(world, random);
    ASSERT_TRUE(theta);
    for (int j = 0; j < 3; ++j) {
      EXPECT_GE((*theta)[j], world.arm.joint_range[static_cast<std::size_t>(j)][0]);
      EXPECT_LE((*theta)[j], world.arm.joint_range[static_cast<std::size_t>(j)][1]);
    }
    furthest = std::max(furthest, (*theta)[1] - (*theta)[2]);
  }
  EXPECT_LE(furthest, SimulatedArm::kFoldLimit);
  EXPECT_GT(furthest, SimulatedArm::kFoldLimit - 0.1);
}

TEST(PoseSampling, AnArmThatIsAlwaysFoldedUpHasNoPoses) {
  auto world = config::reference_world();
  world.arm.joint_range[1] = {1.6, 1.7};
  world.arm.joint_range[2] = {0.0, 0.05};
  Random random(3, "test");
  EXPECT_FALSE(random_joints(world, random));
}

TEST(Quantised, RoundsToWholeStepsAndLeavesExactEncodersAlone) {
  EXPECT_DOUBLE_EQ(quantised(0.26, 0.1), 0.3);
  EXPECT_DOUBLE_EQ(quantised(-0.26, 0.1), -0.3);
  EXPECT_DOUBLE_EQ(quantised(0.26, 0.0), 0.26);
}

}  // namespace
}  // namespace palpate::sim
