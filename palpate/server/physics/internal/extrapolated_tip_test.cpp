#include "palpate/server/physics/internal/extrapolated_tip.h"

#include <gtest/gtest.h>

namespace palpate::server::physics {
namespace {

scene::TipState moving_tip() {
  scene::TipState tip;
  tip.time = Instant<PhysicsClock>::from_seconds(5.0);
  tip.X_world_tip = {so3_exp(Vector3(0.1, -0.2, 0.3)), Vector3(0.1, -1.3, 1.7)};
  tip.velocity = Vector3(2.0, -1.0, 0.5);
  tip.angular_velocity = Vector3(0.0, 6.0, 0.0);
  return tip;
}

TEST(CarriedTip, StaysToTheLastBitWhereNoTimeHasPassed) {
  const scene::TipState tip = moving_tip(), carried = extrapolated_to(tip, tip.time);
  EXPECT_EQ(carried.X_world_tip.translation, tip.X_world_tip.translation);
  EXPECT_EQ(carried.X_world_tip.rotation.coeffs(), tip.X_world_tip.rotation.coeffs());
  EXPECT_EQ(carried.time, tip.time);
}

TEST(CarriedTip, MovesAndTurnsByItsVelocities) {
  const scene::TipState tip = moving_tip();
  const auto now = tip.time + std::chrono::microseconds(800);
  const scene::TipState carried = extrapolated_to(tip, now);
  EXPECT_EQ(carried.time, now);
  EXPECT_LT((carried.X_world_tip.translation - Vector3(0.1016, -1.3008, 1.7004)).norm(), 1e-12);
  // About World's axes: by 6 rad/s times 0.8 ms about y, applied after the turn it had.
  const Quaternion expected(Eigen::AngleAxisd(0.0048, Vector3::UnitY()) * tip.X_world_tip.rotation);
  EXPECT_LT(angle_between(carried.X_world_tip.rotation, expected), 1e-9);
}

TEST(CarriedTip, IsNotSentAwayWhileTheHapticLoopStandsStill) {
  const scene::TipState tip = moving_tip();
  const scene::TipState carried = extrapolated_to(tip, tip.time + std::chrono::seconds(2));
  EXPECT_LT((carried.X_world_tip.translation - tip.X_world_tip.translation - 0.003 * tip.velocity).norm(),
            1e-12);
}

TEST(CarriedTip, OfAReadingFromTheFutureIsTheReading) {
  const scene::TipState tip = moving_tip();
  EXPECT_EQ(extrapolated_to(tip, tip.time - std::chrono::milliseconds(1)).X_world_tip.translation,
            tip.X_world_tip.translation);
}

}  // namespace
}  // namespace palpate::server::physics
