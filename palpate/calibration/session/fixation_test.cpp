#include "palpate/calibration/session/fixation.h"

#include <gtest/gtest.h>

namespace palpate::calibration::session {
namespace {

device::ArmSample sample_at(double t, const Vector3& joints) {
  return {Instant<ArmClock>::from_seconds(t), joints, Vector3::Zero()};
}

TEST(Fixation, HoldsWithNothingWhereItBegan) {
  const Vector3 joints(0.1, 0.6, 0.3);
  Fixation fixation({}, sample_at(0.0, joints));
  EXPECT_EQ(fixation.force(sample_at(0.001, joints)).norm(), 0.0);
}

TEST(Fixation, PullsBackWithTheStatedStiffnessOnceTheStylusStands) {
  const Vector3 joints(0.1, 0.6, 0.3), moved(0.11, 0.61, 0.29);
  FixationSettings settings;
  Fixation fixation(settings, sample_at(0.0, joints));
  Vector3 force;
  for (int i = 1; i <= 200; ++i) force = fixation.force(sample_at(0.001 * i, moved));
  const Vector3 displacement = device::phantom_tip(moved).m - device::phantom_tip(joints).m;
  EXPECT_LT((force + settings.stiffness * displacement).norm(), 1e-9);
  EXPECT_NEAR(fixation.displacement(), displacement.norm(), 1e-15);
}

TEST(Fixation, DampsAgainstTheMotion) {
  FixationSettings settings;
  settings.stiffness = 0.0;
  Fixation fixation(settings, sample_at(0.0, {0, 0.6, 0.3}));
  Vector3 force;
  const double rate = 0.5;  // rad/s of the first joint
  double t = 0.0;
  for (int i = 1; i <= 100; ++i)
    force = fixation.force(sample_at(t = 0.001 * i, {rate * 0.001 * i, 0.6, 0.3}));
  const Vector3 velocity = device::phantom_jacobian({rate * t, 0.6, 0.3}).col(0) * rate;
  // The filter lags by its 4 ms; the direction turns by 0.5 rad/s * 4 ms meanwhile.
  EXPECT_LT((force + settings.damping * velocity).norm(), 0.01 * settings.damping * velocity.norm());
}

TEST(Fixation, AReadingTwiceDoesNotDisturbTheSpeed) {
  Fixation fixation({}, sample_at(0.0, {0, 0.6, 0.3}));
  const auto sample = sample_at(0.001, {0.001, 0.6, 0.3});
  const Vector3 first = fixation.force(sample);
  EXPECT_EQ(fixation.force(sample), first);
}

}  // namespace
}  // namespace palpate::calibration::session
