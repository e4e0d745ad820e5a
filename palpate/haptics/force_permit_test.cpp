#include "palpate/haptics/force_permit.h"

#include <gtest/gtest.h>

#include "palpate/haptics/haptic_bench_test.h"

namespace palpate::haptics {
namespace {

device::ArmFacts real_arm(const std::string& identity = "maker model 7") {
  device::ArmFacts facts;
  facts.identity = identity;
  return facts;
}

rig::Rig checked_rig() {
  rig::Rig rig;
  rig.arm = bench_calibration();
  rig.arm->rest_readings = {0.1, 0.2, 0.3};
  rig::ForceCalibration forces = rig::force_calibration_of(rig, real_arm().identity);
  forces.joint_gains = Vector3::Ones();
  rig.forces = forces;
  return rig;
}

HapticSettings with(const ForcePermit& permit) {
  HapticSettings settings = without_ramp();
  settings.permit = permit;
  return settings;
}

// The largest force that an arm is ever commanded while 5 N are asked for.
double largest_force(const HapticSettings& settings) {
  HapticBench bench(settings);
  bench.message.continuous = {5.0, 0.0, 0.0};
  bench.live(200);
  bench.loop.rearm();
  bench.live(200);
  return bench.arm.largest;
}

TEST(ForcePermit, AnArmThatNobodyHasCheckedIsGivenNoForceWhateverIsAskedOrRearmed) {
  HapticBench bench(with({}));
  EXPECT_EQ(bench.loop.state(), ForceState::safe);
  EXPECT_EQ(bench.loop.fault(), ForceFault::arm_unchecked);
  EXPECT_EQ(device::condition_text({bench.loop.condition().state, bench.loop.condition().fault}),
            "safe: arm not checked");
  bench.message.continuous = {5.0, 0.0, 0.0};
  bench.message.impact = bench_impact(1, 5.0, bench.now);
  bench.live(300);
  EXPECT_FALSE(bench.loop.rearm());
  bench.live(300);
  EXPECT_EQ(bench.arm.largest, 0.0);
  EXPECT_EQ(bench.loop.condition().trips, 0u);    // nothing has tripped: there never was a force
  EXPECT_GT(largest_force(without_ramp()), 4.0);  // the same with a computed arm
}

TEST(ForcePermit, AChainOfTheSameNameWithAnotherRowIsAnotherModel) {
  rig::Rig rig = checked_rig();
  rig.arm->model.kind = device::ArmModel::Kind::dh;
  rig.arm->model.joints = {{0.0, 1.57, 0.3, 0.0}, {0.2, 0.0, 0.0, 0.0}, {0.2, 0.0, 0.0, 0.0}};
  rig.forces->model_numbers = rig::numbers_of(rig.arm->model);
  const auto given = [&] { return ForcePermit::of(real_arm(), rig).given(); };
  EXPECT_TRUE(given());
  for (double device::DhJoint::*number :
       {&device::DhJoint::a, &device::DhJoint::d, &device::DhJoint::alpha, &device::DhJoint::theta_offset}) {
    rig.arm->model.joints[1].*number += 0.02;
    EXPECT_FALSE(given());
    rig.arm->model.joints[1].*number -= 0.02;
  }
  rig.arm->model.tool.z() += 0.02;
  EXPECT_FALSE(given());
  rig.arm->model.tool.z() -= 0.02;
  EXPECT_TRUE(given());
  rig.arm->model.joints.push_back(rig.arm->model.joints.back());
  EXPECT_FALSE(given());
}

TEST(ForcePermit, NeedsACheckOfThisArmWithThisModelAndZero) {
  const auto permit = [](const rig::Rig& rig, const std::string& identity = real_arm().identity) {
    return ForcePermit::of(real_arm(identity), rig);
  };
  EXPECT_TRUE(permit(checked_rig()).given());
  rig::Rig rig = checked_rig();
  rig.forces.reset();
  EXPECT_FALSE(permit(rig).given());
  EXPECT_NE(permit(rig).words().find("palpate calibrate forces"), std::string::npos);
  EXPECT_FALSE(permit(checked_rig(), "maker model 8").given());
  EXPECT_NE(permit(checked_rig(), "maker model 8").words().find("'maker model 8', and was 'maker model 7'"),
            std::string::npos);
  rig = checked_rig();
  rig.arm->model.name = "phantom-omni";
  EXPECT_FALSE(permit(rig).given());
  EXPECT_NE(permit(rig).words().find("model has changed"), std::string::npos);
  rig = checked_rig();
  rig.arm->model.lengths.l2 += 0.002;  // calibrated anew
  EXPECT_TRUE(permit(rig).given());
  rig.arm->model.lengths.l2 += 0.003;  // another link
  EXPECT_FALSE(permit(rig).given());
  EXPECT_NE(permit(rig).words().find("has other lengths or angles"), std::string::npos);
  rig = checked_rig();
  rig.nominal_arm.lengths.l1 += 0.01;  // commanded forces become other torques
  EXPECT_FALSE(permit(rig).given());
  EXPECT_NE(permit(rig).words().find("nominal model has changed"), std::string::npos);
  rig = checked_rig();
  rig.arm->correction.gain[1] *= 1.05;
  EXPECT_FALSE(permit(rig).given());
  rig = checked_rig();
  rig.forces->identity.clear();  // of no arm in particular
  EXPECT_FALSE(permit(rig, "").given());
  EXPECT_NE(permit(rig, "").words().find("does not say which arm it is"), std::string::npos);
  for (const double peak : {0.0, -1.0, std::nan("")}) {
    rig = checked_rig();
    rig.forces->peak = peak;
    EXPECT_FALSE(permit(rig).given());
  }
  rig = checked_rig();
  rig.forces->dead_man_button = 33;
  EXPECT_FALSE(permit(rig).given());
  rig = checked_rig();
  rig.arm->rest_readings[1] += 0.02;
  EXPECT_FALSE(permit(rig).given());
  EXPECT_NE(permit(rig).words().find("zero has changed: the rest reading of joint 2"), std::string::npos);
  rig.arm->rest_readings[1] -= 0.015;  // within half a degree
  EXPECT_TRUE(permit(rig).given());
  rig = checked_rig();
  rig.arm->correction.offset[2] -= 0.02;
  EXPECT_FALSE(permit(rig).given());
  rig = checked_rig();
  rig.arm.reset();
  EXPECT_FALSE(permit(rig).given());
  device::ArmFacts computed = real_arm("lab");
  computed.simulated = true;
  EXPECT_TRUE(ForcePermit::of(computed, {}).given());
}

TEST(ForcePermit, WithoutAKnownWeightThePeakStaysAtOneNewton) {
  rig::Rig rig = checked_rig();
  EXPECT_NE(ForcePermit::of(real_arm(), rig).words().find("below 1 N"), std::string::npos);
  EXPECT_LE(largest_force(with(ForcePermit::of(real_arm(), rig))), 1.0 + 1e-9);
  EXPECT_GT(largest_force(with(ForcePermit::of(real_arm(), rig))), 0.9);
  rig.forces->peak = 8.5;  // whoever wrote that
  EXPECT_LE(largest_force(with(ForcePermit::of(real_arm(), rig))), 1.0 + 1e-9);
  rig.forces->gain = 1.02;  // what is felt stays below the limits
  EXPECT_GT(largest_force(with(ForcePermit::of(real_arm(), rig))), 4.0);
  EXPECT_EQ(ForcePermit::of(real_arm(), rig).words(), "");
}

TEST(ForcePermit, OfAnArmThatStatesItsPlaceThePeakStaysAtOneNewtonWhateverAWeightTold) {
  rig::Rig rig = checked_rig();
  rig.forces->peak = 8.5;
  rig.forces->gain = 1.0;
  device::ArmFacts arm = real_arm();
  arm.states_place = true;
  EXPECT_NE(ForcePermit::of(arm, rig).words().find("below 1 N"), std::string::npos);
  EXPECT_LE(largest_force(with(ForcePermit::of(arm, rig))), 1.0 + 1e-9);
  EXPECT_GT(largest_force(with(ForcePermit::of(real_arm(), rig))), 4.0);
}

TEST(ForcePermit, AnArmThatGivesMoreThanIsCommandedIsCommandedLess) {
  rig::Rig rig = checked_rig();
  rig.forces->peak = 8.5;
  rig.forces->gain = 1.6;
  const ForceLimits limits = ForcePermit::of(real_arm(), rig).lowered({});
  EXPECT_NEAR(1.6 * limits.peak_n, ForceLimits{}.peak_n, 1e-12);
  EXPECT_NEAR(1.6 * limits.continuous_n, ForceLimits{}.continuous_n, 1e-12);
  rig.forces->gain = 0.8;  // a weak one is not driven harder
  EXPECT_EQ(ForcePermit::of(real_arm(), rig).lowered({}).peak_n, ForceLimits{}.peak_n);
}

TEST(ForcePermit, ADeadManSwitchGivesForceOnlyWhileItIsHeld) {
  rig::Rig rig = checked_rig();
  rig.forces->gain = 1.0;
  rig.forces->peak = 8.5;
  rig.forces->dead_man_button = 2;
  HapticBench bench(with(ForcePermit::of(real_arm(), rig)));
  bench.message.continuous = {2.0, 0.0, 0.0};
  bench.live(100);
  bench.arm.sample.buttons = 1;  // another one
  bench.live(100);
  EXPECT_EQ(bench.arm.largest, 0.0);
  bench.arm.sample.buttons = 2;
  bench.live(200);
  EXPECT_GT(bench.arm.force.norm(), 1.8);
  bench.arm.sample.buttons = 0;
  bench.arm.steepest = 0.0;
  int gone = 0;
  while (bench.arm.force.norm() > 0.0 && gone < 100) bench.live(), ++gone;
  EXPECT_LE(gone, 16);  // the fade of 15 ms
  EXPECT_LE(bench.arm.steepest, 3.0 + 1e-9);
  EXPECT_EQ(device::condition_text({bench.loop.state(), bench.loop.fault()}), "degraded: button released");
  EXPECT_EQ(bench.loop.condition().trips, 0u);
  bench.arm.sample.buttons = 3;
  bench.live(300);
  EXPECT_GT(bench.arm.force.norm(), 1.8);
  EXPECT_EQ(bench.loop.state(), ForceState::running);
}

}  // namespace
}  // namespace palpate::haptics
