// The haptic loop on arms that are no PHANToM: what a hand feels is what was asked for, and every limit holds.
#include <gtest/gtest.h>

#include "palpate/core/random.h"
#include "palpate/haptics/chain_arm_for_tests.h"
#include "palpate/haptics/haptic_bench_test.h"
#include "palpate/haptics/trip_writer.h"
#include "palpate/math/random_vector.h"
#include "tests/allocation_count.h"

namespace palpate::haptics {
namespace {

struct ChainBench {
  explicit ChainBench(const device::ArmModel& model, bool takes_torques = true,
                      HapticSettings chosen = without_ramp())
      : settings(with_range(chosen, model)),
        calibration(chain_calibration(model)),
        arm(bent(model), takes_torques) {
    made();
  }
  static HapticSettings with_range(HapticSettings settings, const device::ArmModel& model) {
    settings.limits.joint_range = force_limits_of(model).joint_range;
    return settings;
  }
  void made() { loop.emplace(arm, calibration, calibration.model, settings, input, output); }
  void live(int ticks = 1) {
    for (int i = 0; i < ticks; ++i) {
      now += settings.period;
      message.time = now;
      input.write(message);
      loop->tick(now);
    }
  }
  // N, World: the force whose work in any motion of the joints is nearest to that of the motors.
  Vector3 felt() const {
    const Eigen::Matrix3Xd J = numeric_jacobian(calibration, arm.sample.joints);
    return (J * J.transpose()).inverse() * J * arm.torques;
  }
  // N m: of the torques, what no force at the tip can account for.
  double unaccounted() const {
    return (arm.torques - numeric_jacobian(calibration, arm.sample.joints).transpose() * felt()).norm();
  }

  HapticSettings settings{.permit = ForcePermit::of_simulated_arm()};
  rig::ArmCalibration calibration;
  ChainArm arm;
  TripleBuffer<HapticInput> input;
  TripleBuffer<scene::TipState> output;
  HapticInput message;
  Instant<PhysicsClock> now;
  std::optional<HapticLoop> loop;
};

TEST(ChainArm, TheHandFeelsTheForceThatWasAskedFor) {
  for (const auto& model : {three_joint_arm(), six_joint_arm()}) {
    ChainBench bench(model);
    Random random(1, "chain/felt");
    bench.live(50);
    for (int i = 0; i < 200; ++i) {
      bench.arm.sample.joints += 2e-4 * Eigen::VectorXd::Ones(model.joint_count());
      bench.message.continuous = Vector3(0.4, -0.5, 0.3) + normal3(random, 0.01);
      bench.live();
      if (i == 0) continue;  // touch has just begun
      // The damping of the passivity observer, which a moving hand may feel beside it.
      const double most_damping =
          bench.settings.limits.most_damping_n_s_m * bench.loop->tip().velocity.norm();
      EXPECT_LE((bench.felt() - bench.message.continuous).norm(), most_damping + 1e-6);
      EXPECT_LT(bench.unaccounted(), 1e-7);
    }
    bench.live(100);  // it stands still
    EXPECT_LT((bench.felt() - bench.message.continuous).norm(), 1e-6) << model.name;
    EXPECT_LT(
        (bench.loop->tip().X_world_tip.translation - chain_tip(bench.calibration, bench.arm.sample.joints))
            .norm(),
        1e-12);
    EXPECT_FALSE(bench.arm.asked_wrongly);
  }
}

// Hand and wall: joints with inertia and friction, a hand's spring from the tip to where it wants to be,
// behind a wall that pushes back. At rest the hand holds what the wall gives.
TEST(ChainArm, AHandThatPressesAgainstAWallHoldsItsForce) {
  for (const auto& model : {three_joint_arm(), six_joint_arm()}) {
    ChainBench bench(model);
    const auto& c = bench.calibration;
    const Vector3 place = chain_tip(c, bench.arm.sample.joints), into = Vector3(0.6, -0.48, 0.64);
    const Vector3 wanted = place + 0.02 * into;
    constexpr double kHand = 40.0, kWall = 200.0;  // N/m
    device::JointVector rate = device::JointVector::filled(model.joint_count(), 0.0);
    Vector3 pull = Vector3::Zero();
    for (int tick = 0; tick < 6000; ++tick) {
      bench.message.continuous =
          -kWall * std::max(0.0, into.dot(bench.loop->tip().X_world_tip.translation - place)) * into;
      bench.live();
      pull = kHand * (wanted - chain_tip(c, bench.arm.sample.joints));
      const Eigen::VectorXd torques =
          bench.arm.torques + numeric_jacobian(c, bench.arm.sample.joints).transpose() * pull;
      constexpr double kInertia = 0.02, kFriction = 0.4;  // kg m^2, N m s
      rate += 1e-3 / kInertia * (torques - kFriction * rate);
      bench.arm.sample.joints += 1e-3 * rate.cwiseQuotient(c.correction.gain);
    }
    EXPECT_LT(rate.norm(), 1e-4) << model.name;
    const double depth = into.dot(chain_tip(c, bench.arm.sample.joints) - place);
    EXPECT_NEAR(depth, 0.02 * kHand / (kHand + kWall), 2e-5) << model.name;
    EXPECT_NEAR((bench.felt() + pull).norm(), 0.0, 2e-3) << model.name;  // N, of 0.67
    EXPECT_EQ(bench.loop->condition().trips, 0u);
  }
}

TEST(ChainArm, MotorsAreNeverAskedForMoreThanTheirLimits) {
  for (const auto& model : {three_joint_arm(), six_joint_arm()}) {
    ChainBench bench(model);
    bench.arm.most = device::JointVector::filled(model.joint_count(), 0.3);
    bench.arm.most[0] = 0.05;
    bench.made();
    Random random(2, "chain/limits");
    for (int i = 0; i < 3000; ++i) {
      if (i % 100 == 0) bench.message.continuous = normal3(random, 3.0);
      if (i % 150 == 0)
        bench.message.impact = bench_impact(static_cast<std::uint64_t>(i / 150 + 1), 10.0, bench.now);
      const Eigen::VectorXd way = Eigen::VectorXd::Constant(model.joint_count(), 6e-4 * std::sin(0.02 * i));
      bench.arm.sample.joints += way;
      bench.live();
    }
    EXPECT_LE(bench.arm.largest_share, 1.0 + 1e-12);
    EXPECT_GT(bench.arm.largest_share, 0.5);
    EXPECT_GT(bench.loop->statistics().limited_ticks, 500u);
    EXPECT_EQ(bench.loop->condition().trips, 0u) << "a motor's limit is no fault";
  }
}

TEST(ChainArm, PeakAndSlewHoldInNewtonsAtTheTip) {
  ChainBench bench(six_joint_arm());
  bench.live(20);
  bench.message.continuous = {60.0, 0.0, 0.0};
  Vector3 before = bench.felt();
  double largest = 0.0;
  for (int i = 0; i < 100; ++i) {
    bench.live();
    const Vector3 felt = bench.felt();
    EXPECT_LE((felt - before).norm(), bench.settings.limits.slew_n_s * 1e-3 + 1e-6);
    largest = std::max(largest, felt.norm());
    before = felt;
  }
  EXPECT_LE(largest, bench.settings.limits.peak_n + 1e-6);
  EXPECT_GT(largest, bench.settings.limits.peak_n - 0.5);
}

// An arm that takes forces makes torques of them by its own kinematics; the calibrated one differs.
TEST(ChainArm, OfTwoKinematicsTheHandFeelsTheCalibratedOne) {
  ChainBench bench(three_joint_arm(), false);
  device::ArmModel nominal = bench.calibration.model;
  nominal.joints[1].a += 0.004, nominal.joints[2].alpha += 0.03;
  rig::ArmCalibration own = chain_calibration(nominal);
  own.correction = device::JointCorrection::none(3);
  own.X_world_base = {};
  bench.loop.emplace(bench.arm, bench.calibration, nominal, bench.settings, bench.input, bench.output);
  bench.message.continuous = {0.4, -0.5, 0.3};
  bench.live(100);
  EXPECT_GT((bench.calibration.X_world_base.rotation * bench.arm.force - bench.message.continuous).norm(),
            5e-3);
  bench.arm.torques = numeric_jacobian(own, bench.arm.sample.joints).transpose() * bench.arm.force;
  EXPECT_LT((bench.felt() - bench.message.continuous).norm(), 1e-6);
}

TEST(ChainArm, OfMoreThanThreeJointsTheAskedForceGivesTheNearestTorques) {
  Random random(3, "chain/nearest");
  const rig::ArmCalibration calibrated = chain_calibration(six_joint_arm());
  device::ArmModel model = six_joint_arm();
  model.joints[1].a += 0.004, model.joints[3].alpha += 0.03;
  const auto nominal = device::make_kinematics(model);
  const auto real = device::make_kinematics(calibrated.model);
  const device::JointVector psi = bent(model), theta = calibrated.correction.apply(psi);
  const auto device = DeviceForce::at(psi, *nominal, real->jacobian(theta), *real);
  ASSERT_TRUE(device);
  const device::TipJacobian own = nominal->jacobian(psi);
  for (int i = 0; i < 20; ++i) {
    const Vector3 wanted = normal3(random, 1.0), asked = device->M * wanted;
    const Eigen::VectorXd torques = real->jacobian(theta).transpose() * wanted;
    const double off = (own.transpose() * asked - torques).norm();
    EXPECT_LT(off, 0.05 * torques.norm());
    for (int k = 0; k < 200; ++k)
      EXPECT_GE((own.transpose() * (asked + normal3(random, 0.05)) - torques).norm(), off);
  }
  const auto same = DeviceForce::at(theta, *real, real->jacobian(theta), *real);
  ASSERT_TRUE(same);
  EXPECT_LT((same->M - Matrix3::Identity()).norm(), 1e-12);
}

TEST(ChainArm, ASampleOfAnotherNumberOfJointsIsABadReading) {
  for (const Eigen::Index joints : {0, 3, 5, 8}) {
    ChainBench bench(six_joint_arm());
    bench.message.continuous = {0.4, -0.5, 0.3};
    bench.live(100);
    EXPECT_GT(bench.arm.torques.norm(), 0.05);
    const Vector3 tip = bench.loop->tip().X_world_tip.translation;
    bench.arm.sample.joints = device::JointVector::filled(joints, 0.2);
    bench.live(20);
    EXPECT_EQ(bench.loop->fault(), ForceFault::bad_reading);
    EXPECT_EQ(bench.arm.torques.norm(), 0.0);
    EXPECT_EQ(bench.loop->tip().X_world_tip.translation, tip);
    // What is written of it has six columns of readings, filled as far as they go.
    const std::string csv = trip_csv(bench.loop->condition(), bench.loop->records());
    EXPECT_NE(csv.find(fmt::format("reading_{}_rad", std::max<Eigen::Index>(joints, 1))) != std::string::npos,
              joints == 0);
  }
}

TEST(ChainArm, WhereItIsStretchedOrBeyondARangeThereIsNoForce) {
  device::ArmModel model = three_joint_arm();
  model.joints[1].range = {-1.5, 0.2};
  ChainBench bench(model);
  bench.message.continuous = {0.2, 0.1, 0.0};
  bench.live(200);
  EXPECT_GT(bench.arm.torques.norm(), 0.01);
  for (; bench.arm.sample.joints[1] < 0.25; bench.live()) bench.arm.sample.joints[1] += 1e-3;
  bench.live(20);
  EXPECT_EQ(bench.loop->fault(), ForceFault::outside_workspace);
  EXPECT_EQ(bench.arm.torques.norm(), 0.0);
  EXPECT_GT(device::manipulability(device::make_kinematics(model)->jacobian(bench.arm.sample.joints)), 1e-3)
      << "it is its range alone";

  constexpr double kInLine = 0.4;  // with its offset: forearm and upper arm
  ChainBench stretched(three_joint_arm());
  stretched.message.continuous = {0.2, 0.1, 0.0};
  stretched.live(200);
  EXPECT_GT(stretched.arm.torques.norm(), 0.01);
  for (double& elbow = stretched.arm.sample.joints[2]; elbow > kInLine; stretched.live()) elbow -= 1e-3;
  stretched.live(20);
  EXPECT_EQ(stretched.loop->fault(), ForceFault::outside_workspace);
  EXPECT_EQ(stretched.arm.torques.norm(), 0.0);

  ChainBench from_the_start(three_joint_arm());
  from_the_start.arm.sample.joints[2] = kInLine;
  from_the_start.message.continuous = {0.2, 0.1, 0.0};
  from_the_start.live(200);
  EXPECT_FALSE(from_the_start.arm.asked_wrongly);
  EXPECT_EQ(from_the_start.arm.torques.norm(), 0.0);
}

TEST(ChainArm, TooFastForItsLimitItHasNoForceUntilSomebodyRearms) {
  ChainBench bench(six_joint_arm());
  bench.message.continuous = {0.2, 0.1, 0.0};
  bench.live(200);
  for (int i = 0; i < 60; ++i) bench.arm.sample.joints[0] += 0.01, bench.live();  // 10 rad/s
  EXPECT_EQ(bench.loop->fault(), ForceFault::overspeed);
  bench.live(300);
  EXPECT_EQ(bench.arm.torques.norm(), 0.0);
  EXPECT_TRUE(bench.loop->rearm());
  bench.live(300);
  EXPECT_LT((bench.felt() - bench.message.continuous).norm(), 1e-6);
}

TEST(ChainArm, WhatDoesNotGoTogetherIsRefused) {
  ChainBench bench(six_joint_arm());
  const auto make = [&](const rig::ArmCalibration& c, const device::ArmModel& nominal) {
    bench.loop.emplace(bench.arm, c, nominal, bench.settings, bench.input, bench.output);
  };
  EXPECT_THROW(make(bench.calibration, three_joint_arm()), std::invalid_argument);
  rig::ArmCalibration few = bench.calibration;
  few.correction = device::JointCorrection::none(3);
  EXPECT_THROW(make(few, bench.calibration.model), std::invalid_argument);
  bench.arm.most[2] = 0.0;
  EXPECT_THROW(make(bench.calibration, bench.calibration.model), std::invalid_argument);
  bench.arm.most = device::JointVector::filled(3, 1.0);
  EXPECT_THROW(make(bench.calibration, bench.calibration.model), std::invalid_argument);
}

TEST(ChainArm, ATickDoesNotAllocate) {
  ChainBench bench(six_joint_arm());
  bench.message.continuous = {0.4, -0.5, 0.3};
  bench.live();
  const device::JointVector far = device::JointVector::filled(3, 0.1);
  const device::JointVector step = device::JointVector::filled(6, 1e-4);
  const std::size_t before = allocations();
  for (int i = 0; i < 1000; ++i) {
    bench.arm.sample.joints += step;
    bench.live();
  }
  bench.arm.sample.joints = far;
  bench.live(30);
  EXPECT_EQ(allocations() - before, 0u);
}

}  // namespace
}  // namespace palpate::haptics
