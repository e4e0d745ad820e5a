#include "palpate/sim/simulated_arm.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <numbers>

#include "palpate/core/units.h"

namespace palpate::sim {
namespace {

// An arm whose readings are true and that nothing holds back.
config::WorldFile ideal() {
  auto world = config::reference_world();
  world.arm.gain_sd = world.arm.offset_sd = world.arm.gimbal_gain_sd = world.arm.gimbal_offset_sd = 0.0;
  world.arm.friction = 0.0;
  return world;
}

SimulatedHand no_hand(const SimulatedArm& arm) {
  return SimulatedHand({}, arm.state().tip, arm.state().orientation);
}

TEST(SimulatedArm, RestsAtResetWithThePlaceOfTheBase) {
  const auto world = ideal();
  const auto truth = draw_truth(world, 1);
  SimulatedArm arm(world, truth);
  auto hand = no_hand(arm);
  for (int i = 0; i < 4000; ++i) arm.step(0.00025, hand);
  EXPECT_EQ(arm.state().tip, truth.X_world_base.translation);
  EXPECT_LT(arm.theta_of(arm.state()).norm(), 1e-12);
}

TEST(SimulatedArm, ForceOnTheFreeStylusAcceleratesItsApparentMass) {
  const auto world = ideal();
  const auto truth = draw_truth(world, 1);
  SimulatedArm arm(world, truth);
  auto hand = no_hand(arm);
  const Vector3 force(0.2, 0.3, -0.1);  // ArmBase
  constexpr int kSteps = 200;
  for (int i = 0; i < kSteps; ++i) {
    if (i % 40 == 0) arm.command(force);  // every 10 ms, before it lets go
    arm.step(0.00025, hand);
  }
  const Vector3 expected = truth.X_world_base.rotation * force / world.arm.apparent_mass * (kSteps * 0.00025);
  // Torques follow the moving geometry once a millisecond, and readings are quantised: 1 %.
  EXPECT_LT((arm.state().velocity - expected).norm(), 0.01 * expected.norm());
}

TEST(SimulatedArm, ItLetsGoOfACommandThatIsNotRenewed) {
  const auto world = ideal();
  const auto truth = draw_truth(world, 1);
  SimulatedArm arm(world, truth);
  auto hand = no_hand(arm);
  arm.command({0.2, 0.3, -0.1});
  for (int i = 0; i < 79; ++i) arm.step(0.00025, hand);
  EXPECT_EQ(arm.held(), Vector3(0.2, 0.3, -0.1));
  for (int i = 0; i < 6; ++i) arm.step(0.00025, hand);
  EXPECT_EQ(arm.held(), Vector3::Zero());
  EXPECT_EQ(arm.motor_force(), Vector3::Zero());
}

TEST(SimulatedArm, ForceIsClampedToTheMotorsLimitAndNonsenseIsNone) {
  const auto world = ideal();
  SimulatedArm arm(world, draw_truth(world, 1));
  arm.command({100.0, 0, 0});
  EXPECT_NEAR(arm.motor_force().norm(), world.arm.max_force, 0.01 * world.arm.max_force);
  arm.command({std::nan(""), 0, 0});
  EXPECT_EQ(arm.motor_force().norm(), 0.0);
}

TEST(SimulatedArm, WrongGainsTurnTheForceThatIsFelt) {
  auto world = ideal();
  world.arm.offset_sd = radians_from_degrees(5.0);
  const auto truth = draw_truth(world, 3);
  SimulatedArm arm(world, truth);
  const Vector3 wanted(0, 2.0, 0);
  arm.command(wanted);
  const Vector3 felt = truth.X_world_base.rotation.conjugate() * arm.motor_force();
  EXPECT_GT((felt - wanted).norm(), 0.02);
  EXPECT_LT((felt - wanted).norm(), 1.0);
}

// At reset each joint pushes along one axis of ArmBase.
TEST(SimulatedArm, MotorsWiredWronglyPushWhereTheyShouldNot) {
  const Vector3 wanted(1.0, 0.5, 0.25);
  const auto felt = [&](const auto& wire) {
    auto world = ideal();
    world.arm.length_sd = 0.0;
    wire(world.arm_faults);
    const auto truth = draw_truth(world, 1);
    SimulatedArm arm(world, truth);
    arm.command(wanted);
    return Vector3(truth.X_world_base.rotation.conjugate() * arm.motor_force());
  };
  EXPECT_LT((felt([](auto&) {}) - wanted).norm(), 1e-9);
  EXPECT_LT((felt([](auto& faults) { faults.mirrored_axis = 2; }) - Vector3(1.0, -0.5, 0.25)).norm(), 1e-9);
  EXPECT_LT((felt([](auto& faults) {
               faults.exchanged_joints = {2, 3};
             }) -
             Vector3(1.0, 0.25, 0.5))
                .norm(),
            1e-9);
  EXPECT_LT((felt([](auto& faults) {
               faults.torque_gains = {0.0, 1.0, 2.0};
             }) -
             Vector3(0.0, 0.5, 0.5))
                .norm(),
            1e-9);
}

TEST(SimulatedArm, ReadingsAreTheTrueAnglesThroughGainOffsetAndQuantum) {
  const auto& world = config::reference_world();
  const auto truth = draw_truth(world, 8);
  SimulatedArm arm(world, truth);
  const Vector3 theta(0.3, 0.5, 0.2);
  arm.place((truth.X_world_base * device::phantom_tip(theta, truth.lengths)).m, truth.X_world_base.rotation);
  const Vector3 psi = arm.joint_readings(arm.theta_of(arm.state()));
  const double quantum = world.arm.encoder_quantum;
  for (int i = 0; i < 3; ++i) {
    EXPECT_LE(std::abs(truth.joints.gain[i] * psi[i] + truth.joints.offset[i] - theta[i]),
              0.51 * quantum * 1.05);
    EXPECT_NEAR(psi[i] / quantum, std::round(psi[i] / quantum), 1e-6);
  }
  EXPECT_GT((psi - theta).norm(), 1e-3);  // the software must not find the truth in them
}

TEST(SimulatedArm, HysteresisMakesReadingsDependOnTheWayTheyWereReached) {
  auto world = ideal();
  world.arm.hysteresis = 2e-3;
  world.arm.encoder_quantum = 0.0;
  const auto truth = draw_truth(world, 1);
  const auto reading_from = [&](double direction) {
    SimulatedArm arm(world, truth);
    SimulatedHand hand({}, arm.state().tip, arm.state().orientation);
    hand.take(Grip::follow, arm.state().tip, Vector3::Zero());
    const auto go = [&](const Vector3& offset) {
      for (int i = 0; i < 8000; ++i) {
        hand.set_target(truth.X_world_base.translation + offset, Vector3::Zero(),
                        truth.X_world_base.rotation);
        arm.step(0.00025, hand);
      }
    };
    go({direction * 0.02, 0, 0});
    go(Vector3::Zero());
    return arm.joint_readings(arm.theta_of(arm.state()))[0] - arm.theta_of(arm.state())[0];
  };
  // Play of 2 mrad: the reading hangs back by half of it on either side.
  EXPECT_NEAR(std::abs(reading_from(1.0) - reading_from(-1.0)), 2e-3, 1e-4);
}

TEST(SimulatedArm, StaysWithinItsReachHoweverTheHandPulls) {
  const auto world = ideal();
  const auto truth = draw_truth(world, 1);
  SimulatedArm arm(world, truth);
  SimulatedHand hand({}, arm.state().tip, arm.state().orientation);
  hand.take(Grip::follow, arm.state().tip, Vector3::Zero());
  for (const Vector3& far : {Vector3(2, 0, 0), Vector3(0, 2, 0), Vector3(0, 0, 2), Vector3(0, -2, 0)}) {
    for (int i = 0; i < 8000; ++i) {
      hand.set_target(arm.within_reach(truth.X_world_base.translation + far), Vector3::Zero(),
                      truth.X_world_base.rotation);
      arm.step(0.00025, hand);
    }
    const Vector3 theta = arm.theta_of(arm.state());
    for (int i = 0; i < 3; ++i) {
      EXPECT_GT(theta[i], world.arm.joint_range[static_cast<std::size_t>(i)][0] - 0.08);
      EXPECT_LT(theta[i], world.arm.joint_range[static_cast<std::size_t>(i)][1] + 0.08);
    }
    EXPECT_LT(arm.state().velocity.norm(), 0.01);
  }
}

// What pulls the stylus out of the arm's reach stretches it; it never stands still and catches up with one leap.
TEST(SimulatedArm, ItsReadingsFollowTheHandBeyondItsReachAndBack) {
  const auto world = ideal();
  const auto truth = draw_truth(world, 1);
  SimulatedArm arm(world, truth);
  SimulatedHand hand({}, arm.state().tip, arm.state().orientation);
  hand.take(Grip::follow, arm.state().tip, Vector3::Zero());
  const Vector3 begin = arm.state().tip;
  // Ahead of the shoulder and upwards, farther than both links together, and past it sideways.
  double fastest = 0.0, farthest = 0.0;
  Vector3 before = device::phantom_tip(arm.theta_of(arm.state()), truth.lengths).m;
  for (int ms = 0; ms < 6000; ++ms) {
    const double phase = 2.0 * std::numbers::pi * ms / 3000.0;
    hand.set_target(begin + truth.X_world_base.rotation *
                                Vector3(0.15 * std::sin(3.0 * phase), 0.1, 0.35 * (1.0 - std::cos(phase))),
                    Vector3::Zero(), hand.orientation());
    for (int k = 0; k < 4; ++k) arm.step(0.00025, hand);
    const Vector3 tip = device::phantom_tip(arm.theta_of(arm.state()), truth.lengths).m;
    fastest = std::max(fastest, (tip - before).norm() / 1e-3 - arm.state().velocity.norm());
    farthest = std::max(farthest, (arm.state().tip - (truth.X_world_base * Point<ArmBase>{tip}).m).norm());
    before = tip;
  }
  EXPECT_GT(farthest, 1e-3) << "the hand does not leave the arm's reach: nothing is tried";
  EXPECT_LT(fastest, 0.5) << "m/s beyond what the tip has";
}

TEST(SimulatedHand, ReachesItsTargetWithBoundedAccelerationAndStopsThere) {
  HandSettings settings;
  SimulatedHand hand(settings, Vector3::Zero(), Quaternion::Identity());
  hand.take(Grip::follow, Vector3::Zero(), Vector3::Zero());
  hand.set_target({0.3, 0.1, 0}, Vector3::Zero(), Quaternion::Identity());
  Vector3 last_place = Vector3::Zero(), last_velocity = Vector3::Zero();
  double largest = 0.0, farthest = 0.0;
  const double h = 0.00025;
  for (int i = 0; i < 4000; ++i) {
    hand.step(h);
    const Vector3 velocity = (hand.planned_place() - last_place) / h;
    largest = std::max(largest, (velocity - last_velocity).norm() / h);
    farthest = std::max(farthest, hand.planned_place().x());
    last_place = hand.planned_place();
    last_velocity = velocity;
  }
  EXPECT_LE(largest, settings.max_acceleration * 1.001);
  EXPECT_LT((hand.planned_place() - Vector3(0.3, 0.1, 0)).norm(), 1e-5);
  EXPECT_LT(farthest, 0.303);
  // No hand of 30 m/s^2 gets 0.32 m away and stops in less than 2 sqrt(d / a) = 0.21 s.
}

TEST(SimulatedHand, NeedsAtLeastTheTimeThatItsAccelerationAllows) {
  SimulatedHand hand({}, Vector3::Zero(), Quaternion::Identity());
  hand.take(Grip::follow, Vector3::Zero(), Vector3::Zero());
  hand.set_target({0.3, 0, 0}, Vector3::Zero(), Quaternion::Identity());
  double t = 0.0;
  while (hand.distance_to_target() > 0.003 && t < 2.0) {
    hand.step(0.00025);
    t += 0.00025;
  }
  EXPECT_GT(t, 2.0 * std::sqrt(0.297 / 30.0));
  EXPECT_LT(t, 0.6);
}

}  // namespace
}  // namespace palpate::sim
