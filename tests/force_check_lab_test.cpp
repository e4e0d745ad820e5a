// The check of forces on the simulated laboratory's arm: true arm, encoders, friction and hand, in virtual time.
#include <gtest/gtest.h>

#include "palpate/calibration/forces/force_session.h"
#include "palpate/device/arm_model.h"
#include "palpate/sim/simulator.h"
#include "palpate/sim/truth_rig.h"

namespace palpate {
namespace {

using calibration::ForceVerdict;
namespace forces = calibration::forces;

class SimulatedHolder : public forces::ForcePerson {
 public:
  SimulatedHolder(sim::Simulator& world, const rig::Rig& rig) : world_(world), rig_(rig) {}
  bool key_held(std::uint32_t) override {
    world_.hand().move_to(target_);
    return true;
  }
  void say(const std::string&) override {}
  void pose_wanted(int pose, const Vector3& tip) override {
    if (pose == 0) middle_ = (rig_.arm->X_world_base * Point<ArmBase>{tip}).m + Vector3(0.0, 0.03, 0.0);
    const Vector3 ways[] = {
        {0.0, 0.0, 0.0}, {-0.09, 0.06, 0.0}, {0.09, 0.06, 0.0}, {-0.09, -0.06, 0.0}, {0.09, -0.06, 0.0}};
    target_.tip.m = middle_ + ways[pose];
  }

 private:
  sim::Simulator& world_;
  const rig::Rig& rig_;
  Vector3 middle_ = Vector3::Zero();
  device::HandTarget target_;
};

calibration::ForceCheck checked(const std::string& faults, std::uint64_t seed, const std::string& arm = "") {
  const auto file = sim::config::parse_world(arm + (faults.empty() ? "" : "[arm_faults]\n" + faults + "\n"),
                                             "world.toml", {});
  EXPECT_TRUE(file) << (file ? "" : file.error().message);
  sim::Simulator world(*file, seed);
  rig::Rig rig = sim::truth_rig(world);
  if (file->states_place()) rig.nominal_arm = rig.arm->model = device::laboratory_delta();
  SimulatedHolder holder(world, rig);
  const auto seen = forces::observe_forces(world.arm(), rig, world.physics_clock(), holder);
  EXPECT_TRUE(seen) << (seen ? "" : seen.error().message);
  if (!seen) return {};
  calibration::ForceCheckSettings settings;
  settings.states_place = file->states_place();
  const auto check = calibration::check_forces(seen->poses, settings);
  EXPECT_TRUE(check) << (check ? "" : check.error().message);
  return check.value_or(calibration::ForceCheck{});
}

TEST(ForceCheckInTheLaboratory, ItsArmAgreesForEverySeed) {
  for (std::uint64_t seed = 1; seed <= 3; ++seed) {
    const auto check = checked("", seed);
    EXPECT_EQ(check.verdict, ForceVerdict::agreed) << seed << ": " << check.words;
    EXPECT_NEAR(check.joint_gains.minCoeff(), 1.0, 0.2);
    EXPECT_NEAR(check.joint_gains.maxCoeff(), 1.0, 0.2);
  }
}

TEST(ForceCheckInTheLaboratory, EachFaultIsRefusedByItsName) {
  EXPECT_EQ(checked("mirrored_axis = 1", 1).verdict, ForceVerdict::axis_mirrored);
  EXPECT_EQ(checked("mirrored_axis = 3", 2).verdict, ForceVerdict::axis_mirrored);
  EXPECT_EQ(checked("exchanged_joints = [2, 3]", 1).verdict, ForceVerdict::joints_exchanged);
  EXPECT_EQ(checked("exchanged_joints = [1, 2]", 2).verdict, ForceVerdict::joints_exchanged);
  EXPECT_EQ(checked("torque_gains = [1, 2, 1]", 1).verdict, ForceVerdict::ratio_off);
  EXPECT_EQ(checked("torque_gains = [0.5, 1, 1]", 2).verdict, ForceVerdict::ratio_off);
  EXPECT_EQ(checked("torque_gains = [1, 1, 0]", 1).verdict, ForceVerdict::joint_without_power);
  EXPECT_EQ(checked("torque_gains = [1, -1, 1]", 2).verdict, ForceVerdict::joint_mirrored);
}

// Which of a delta's motors is wired wrongly its place does not tell, but no such arm may pass.
TEST(ForceCheckInTheLaboratory, ADeltaArmAgreesAndIsRefusedWithAFault) {
  const std::string delta = "[arm]\nmodel = \"laboratory-delta\"\n";
  for (std::uint64_t seed = 1; seed <= 3; ++seed) {
    const auto check = checked("", seed, delta);
    EXPECT_EQ(check.verdict, ForceVerdict::agreed) << seed << ": " << check.words;
    EXPECT_FALSE(check.ratios_told);
  }
  EXPECT_EQ(checked("mirrored_axis = 1", 1, delta).verdict, ForceVerdict::axis_mirrored);
  EXPECT_EQ(checked("mirrored_axis = 2", 2, delta).verdict, ForceVerdict::axis_mirrored);
  for (const char* fault :
       {"exchanged_joints = [1, 2]", "exchanged_joints = [2, 3]", "torque_gains = [1, -1, 1]",
        "torque_gains = [-1, 1, 1]", "torque_gains = [1, 1, 0]"}) {
    const auto check = checked(fault, 1, delta);
    EXPECT_NE(check.verdict, ForceVerdict::agreed) << fault;
  }
}

}  // namespace
}  // namespace palpate
