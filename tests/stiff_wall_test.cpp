// A hand presses the stylus against a wall: rendered classically, a spring at the tip, and as `touch` renders
// it, a rigid wall behind a virtual coupling, through the haptic loop with its passivity observer. The same
// simulated arm and hand in both; how far the tip still swings when it ought to be at rest.
#include <gtest/gtest.h>

#include <algorithm>
#include <utility>

#include "palpate/haptics/haptic_loop.h"
#include "palpate/physics/proxy.h"
#include "palpate/sim/simulated_arm.h"

namespace palpate {
namespace {

constexpr double kStep = 0.00025;  // s, of the world's integration; four to a tick
constexpr int kStepsPerTick = 4;

struct Presser {
  double stiffness = 250.0, damping = 4.0, mass = 0.15;  // of the hand; the reference's
  double friction = 0.0, encoder_quantum = 0.0;          // of the arm
};

sim::config::WorldFile wall_laboratory(const Presser& presser) {
  auto world = sim::config::reference_world();
  world.arm.gain_sd = world.arm.offset_sd = world.arm.length_sd = world.arm.hysteresis = 0.0;
  world.arm.friction = presser.friction;
  world.arm.encoder_quantum = presser.encoder_quantum;
  return world;
}

class SimulatedArmDevice : public device::ArmDevice {
 public:
  explicit SimulatedArmDevice(sim::SimulatedArm& arm) : arm_(arm) {}
  device::ArmSample read() override {
    device::ArmSample sample;
    sample.stamp = stamp_ += Duration(1'000'000);
    const Vector3 theta = arm_.theta_of(arm_.state());
    sample.joints = arm_.joint_readings(theta);
    sample.gimbal = arm_.gimbal_readings(arm_.gimbal_of(arm_.state(), theta));
    return sample;
  }
  void command(const Vector3& force) override { arm_.command(force); }
  void let_go() noexcept override { arm_.command(Vector3::Zero()); }

 private:
  sim::SimulatedArm& arm_;
  Instant<ArmClock> stamp_;
};

struct Rest {
  double swing = 0.0, depth = 0.0;  // m: between the extremes of the last fifth of a second, and its mean
};

// Two seconds at a wall that passes through the place where the arm stands; `into` points into it.
class WallRig {
 public:
  explicit WallRig(const Presser& presser)
      : world_(wall_laboratory(presser)),
        truth_(sim::draw_truth(world_, 1)),
        arm_(world_, truth_),
        place_((truth_.X_world_base * device::phantom_tip({0.1, 0.5, 0.3}, truth_.lengths)).m),
        into_(truth_.X_world_base.rotation * Vector3(1.0, 0.5, -0.5).normalized()),
        hand_({.mass = presser.mass, .damping = presser.damping, .stiffness = presser.stiffness}, place_,
              truth_.X_world_base.rotation) {
    calibration_.model.lengths = truth_.lengths;
    calibration_.correction = truth_.joints;
    calibration_.X_world_base = truth_.X_world_base;
    calibration_.gimbal_gain = truth_.gimbal.gain;
    calibration_.gimbal_offset = truth_.gimbal.offset;
  }

  // force = stiffness * depth, at once and held for a tick.
  Rest classical(double stiffness) {
    return press([&] {
      const Vector3 theta = arm_.joint_readings(arm_.theta_of(arm_.state()));
      const Vector3 tip = (truth_.X_world_base * device::phantom_tip(theta, truth_.lengths)).m;
      const double depth = std::max(0.0, into_.dot(tip - place_));
      arm_.command(truth_.X_world_base.rotation.conjugate() * (-stiffness * depth * into_));
    });
  }

  // A rigid wall behind a coupling of this stiffness, with the coupling's damper as in `touch`.
  Rest coupled(double stiffness, double damping, double most_injected) {
    const scene::TriangleMesh wall = wall_mesh();
    const physics::CollisionMesh mesh(wall);
    physics::Proxy proxy(mesh, {.radius = kRadius});
    proxy.begin(place_ - 0.005 * into_);
    SimulatedArmDevice device(arm_);
    haptics::HapticSettings settings{.permit = haptics::ForcePermit::of_simulated_arm()};
    settings.limits.start_ramp_s = 0.0;
    settings.limits.most_damping_n_s_m = most_injected;
    TripleBuffer<haptics::HapticInput> input;
    TripleBuffer<scene::TipState> output;
    haptics::HapticLoop loop(device, calibration_, {.lengths = truth_.lengths}, settings, input, output);
    Instant<PhysicsClock> now;
    const Rest rest = press([&] {
      now += settings.period;
      loop.tick(now);
      scene::TipState tip;
      output.read(tip);
      const physics::ProxyState& s = proxy.follow(tip.X_world_tip.translation);
      haptics::HapticInput message;
      message.time = now;
      if (s.touching) {
        const double share = std::min(1.0, s.depth / 0.0005);
        const double spring = stiffness * s.depth;
        const double damper = std::max(-spring, -damping * share * s.normal.dot(tip.velocity));
        message.continuous = stiffness * (s.position - tip.X_world_tip.translation) + damper * s.normal;
      }
      input.write(message);
    });
    EXPECT_EQ(loop.condition().trips, 0u);
    damped_share_ =
        static_cast<double>(loop.statistics().damped_ticks) / static_cast<double>(loop.statistics().ticks);
    return rest;
  }
  double damped_share() const { return damped_share_; }  // of the ticks in which the observer damped

 private:
  static constexpr double kRadius = 0.003, kReach = 0.004;  // m: of the proxy; how far the hand wants in

  scene::TriangleMesh wall_mesh() const {
    const Vector3 centre = place_ + kRadius * into_;
    const Vector3 x = into_.unitOrthogonal(), y = into_.cross(x);
    return {{centre - x - y, centre + x - y, centre + x + y, centre - x + y}, {{0, 2, 1}, {0, 3, 2}}};
  }

  template <typename Tick>
  Rest press(Tick tick) {
    const Vector3 start = place_ - 0.005 * into_;
    arm_.place(start, truth_.X_world_base.rotation);
    hand_.take(sim::Grip::none, start, Vector3::Zero());
    hand_.take(sim::Grip::follow, start, Vector3::Zero());
    hand_.set_target(place_ + kReach * into_, Vector3::Zero(), truth_.X_world_base.rotation);
    constexpr int kTicks = 4000, kLast = 200;
    double low = 1.0, high = -1.0, sum = 0.0;
    for (int i = 0; i < kTicks; ++i) {
      tick();
      for (int s = 0; s < kStepsPerTick; ++s) {
        arm_.step(kStep, hand_);
        if (i < kTicks - kLast) continue;
        const double depth = into_.dot(arm_.state().tip - place_);
        low = std::min(low, depth);
        high = std::max(high, depth);
        sum += depth;
      }
    }
    return {high - low, sum / (kLast * kStepsPerTick)};
  }

  sim::config::WorldFile world_;
  sim::Truth truth_;
  sim::SimulatedArm arm_;
  Vector3 place_, into_;
  sim::SimulatedHand hand_;
  rig::ArmCalibration calibration_;
  double damped_share_ = 0.0;
};

constexpr double kMostCoupling = 800.0, kTouchDamper = 2.0;  // N/m, N s/m: what `touch` allows and has
constexpr double kObserver = 2.0;                            // N s/m, that it may inject (ForceLimits)

// The sampled wall's limit is about 2 b / T (palpate/sim/stability_test.cpp has it to 1.5 %).
TEST(StiffWall, ClassicallyItBuzzesBeyondTheSampledLimitAndBehindTheCouplingARigidOneRests) {
  for (const double damping : {4.0, 1.0}) {
    const Presser hand{.damping = damping};
    WallRig rig(hand);
    const double limit = 2.0 * damping / 0.001;
    EXPECT_LT(rig.classical(0.4 * limit).swing, 2e-5) << damping;
    EXPECT_GT(rig.classical(2.0 * limit).swing, 5e-4) << damping;
    const Rest rest = rig.coupled(kMostCoupling, kTouchDamper, kObserver);
    EXPECT_LT(rest.swing, 1e-6) << damping;
    // And pushes back as the coupling says: hand's spring against its own.
    EXPECT_NEAR(rest.depth, 0.004 * hand.stiffness / (hand.stiffness + kMostCoupling), 1e-5);
  }
}

TEST(StiffWall, FrictionAndEncoderStepsOfTheReferenceArmLeaveItAtRestToo) {
  const auto& arm = sim::config::reference_world().arm;
  WallRig rig({.friction = arm.friction, .encoder_quantum = arm.encoder_quantum});
  EXPECT_LT(rig.coupled(kMostCoupling, kTouchDamper, kObserver).swing, 3e-5) << "an encoder step";
}

// Colgate and Schenkel ask for b > K T / 2, and for 3 K T / 2 where the force comes a tick late: 1.2 N s/m. A
// hand of 1, and an arm that nobody damps, are below it.
TEST(StiffWall, WithoutTheCouplingsDamperTheObserverKeepsTheLightestHandsQuiet) {
  for (const auto& [hand, rests] :
       {std::pair{Presser{.damping = 1.0}, 1e-4}, std::pair{Presser{.damping = 0.2, .mass = 0.0}, 1e-4}}) {
    WallRig rig(hand);
    EXPECT_GT(rig.coupled(kMostCoupling, 0.0, 0.0).swing, 1e-3) << hand.damping;
    EXPECT_LT(rig.coupled(kMostCoupling, 0.0, kObserver).swing, rests) << hand.damping;
    EXPECT_GT(rig.damped_share(), 0.3);
  }
}

// Why the coupling is soft: what the observer may inject is far from what a stiff one would need.
TEST(StiffWall, TheObserverAloneDoesNotMakeAStiffCouplingQuiet) {
  WallRig rig(Presser{});
  EXPECT_GT(rig.coupled(12000.0, 0.0, kObserver).swing, 2e-4);
  EXPECT_LT(rig.coupled(12000.0, 0.0, kObserver).swing, 5e-3) << "the shaper's limits bound it";
}

}  // namespace
}  // namespace palpate
