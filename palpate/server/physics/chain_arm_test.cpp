// The physics server as a process on an arm that is no PHANToM, opened by a driver under a name of its own.
#include <gtest/gtest.h>

#include <atomic>
#include <mutex>

#include "palpate/haptics/chain_arm_for_tests.h"
#include "palpate/scene/generic_view.h"
#include "palpate/server/physics/physics_process.h"
#include "palpate/time/clock.h"
#include "tests/own_run_directory.h"

namespace palpate::server::physics {
namespace {

const Vector3 kPush(0.3, -0.4, 0.2);  // N, World

struct Push : scene::ContactLaw {
  Vector3 force(const scene::TipState&, double) noexcept override { return kPush; }
  double force_bound() const override { return 1.0; }
  Duration cost_bound() const override { return std::chrono::microseconds(200); }
};

class Pusher : public scene::Application {
 public:
  void step(Instant<PhysicsClock>, Duration, const scene::TipState&, scene::SceneState&) override {}
  const scene::ImpactEvent& impact() const override { return none_; }
  scene::ContactLaw* contact_law() override { return &push_; }

 private:
  void begin() override {}
  void reset() override {}
  scene::ImpactEvent none_;
  Push push_;
};

scene::ApplicationSpec pusher() {
  scene::ApplicationSpec spec;
  spec.name = "pusher";
  spec.summary = "pushes";
  spec.make_physics = [](const auto&, const auto&) { return std::make_unique<Pusher>(); };
  spec.make_view = [](const auto& scene) {
    return std::make_unique<scene::GenericView>(scene.application, scene.shape_vertices);
  };
  return spec;
}

// What the arm was asked for while it stood still; written by the haptic thread.
struct Asked {
  std::atomic<int> commands{0}, right{0}, beyond{0};
};

// Stands still, stamps by this machine's clock, and judges each command.
class StillChain : public device::ArmDevice, private device::JointMotors {
 public:
  StillChain(const rig::ArmCalibration& arm, const device::JointVector& psi, Asked& asked)
      : psi_(psi),
        expected_(haptics::numeric_jacobian(arm, psi).transpose() * kPush),
        limits_(device::JointVector::filled(psi.size(), 10.0)),
        asked_(asked) {}
  device::ArmSample read() override {
    device::ArmSample sample;
    sample.stamp = clock_.now();
    sample.joints = psi_;
    return sample;
  }
  device::JointMotors* motors() override { return this; }
  void command(const Vector3&) override { ++asked_.beyond; }
  void let_go() noexcept override {}

 private:
  void command(const device::JointVector& torques) override {
    ++asked_.commands;
    asked_.right += torques.size() == expected_.size() && (torques - expected_).norm() < 1e-6;
    asked_.beyond += torques.size() != expected_.size() || !torques.allFinite() ||
                     torques.norm() > expected_.norm() + 1e-6;
  }
  device::JointVector limits() const override { return limits_; }

  MonotonicClock<ArmClock> clock_;
  device::JointVector psi_, expected_, limits_;
  Asked& asked_;
};

class OpenedChain : public device::OpenedArm {
 public:
  OpenedChain(std::unique_ptr<StillChain> arm, int joints) : arm_(std::move(arm)), joints_(joints) {}
  device::ArmDevice& device() override { return *arm_; }
  device::ArmFacts facts() const override {
    return {.simulated = true, .identity = "chain", .joints = joints_, .peak_n = 3.0, .continuous_n = 0.8};
  }

 private:
  std::unique_ptr<StillChain> arm_;
  int joints_;
};

class ChainProcess : public testing::Test {
 protected:
  PhysicsProcessOptions options(const device::ArmModel& model) {
    PhysicsProcessOptions made;
    made.rig.arm = haptics::chain_calibration(model);
    made.rig.nominal_arm = model;
    made.applications = {pusher()};
    made.scene.application = "pusher";
    device::Driver driver;
    driver.scheme = "chain";
    driver.summary = "a chain of joints that stands still";
    driver.arm.emplace();
    driver.arm->form = "chain";
    driver.arm->open =
        [this, arm = *made.rig.arm](
            const device::ArmRequest& request) -> Expected<std::unique_ptr<device::OpenedArm>> {
      nominal_ = request.nominal;
      const device::JointVector psi = haptics::bent(arm.model);
      return std::make_unique<OpenedChain>(std::make_unique<StillChain>(arm, psi, asked_),
                                           static_cast<int>(psi.size()));
    };
    made.drivers.add(driver);
    made.arm.uri = "chain";
    made.real_time = false;
    made.seconds = 3.0;  // the force has risen after one
    return made;
  }

  OwnRunDirectory run_directory_;
  Asked asked_;
  device::ArmModel nominal_;
};

TEST_F(ChainProcess, ItsMotorsGetTheTorquesOfTheContactForce) {
  for (const auto& model : {haptics::three_joint_arm(), haptics::six_joint_arm()}) {
    asked_.commands = asked_.right = asked_.beyond = 0;
    const auto result = run_physics_process(options(model));
    ASSERT_TRUE(result) << result.error().message;
    EXPECT_EQ(nominal_.name, model.name);
    EXPECT_GT(asked_.commands, 0);
    EXPECT_GT(asked_.right, 0) << model.name << ": of " << asked_.commands << " commands";
    EXPECT_EQ(asked_.beyond, 0);
    EXPECT_NEAR((*result)["force"]["peak_n"].get<double>(), kPush.norm(), 1e-6);
  }
}

TEST_F(ChainProcess, ARigOfAnotherArmIsRefusedInWords) {
  auto asked = options(haptics::six_joint_arm());
  asked.rig.arm = haptics::chain_calibration(haptics::three_joint_arm());
  asked.rig.nominal_arm = haptics::three_joint_arm();
  const auto refusal = run_physics_process(asked);
  ASSERT_FALSE(refusal);
  EXPECT_EQ(refusal.error().exit_code(), 1);
  EXPECT_EQ(
      refusal.error().message,
      "arm chain: the device has 6 joints, the rig's arm three has 3; name the device that this rig was "
      "calibrated with, or calibrate this one (palpate calibrate arm)");
}

}  // namespace
}  // namespace palpate::server::physics
