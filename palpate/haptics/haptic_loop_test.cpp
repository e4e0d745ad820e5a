#include "palpate/haptics/haptic_loop.h"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <cmath>
#include <limits>

#include "palpate/core/random.h"
#include "tests/allocation_count.h"

namespace palpate {
namespace {

class FakeArm : public ArmDevice {
 public:
  ArmSample read() override { return sample; }
  void command(const Vector3& f) override {
    force = f;
    ++commands;
  }
  ArmSample sample;
  Vector3 force = Vector3::Zero();
  int commands = 0;
};

ArmCalibration calibration() {
  ArmCalibration c;
  c.correction.gain = {1.01, 0.99, 1.005};
  c.correction.offset = {0.0, 0.02, -0.015};
  c.X_world_base = {rotation_from_xyz({0.026, -0.07, 0.014}), {0.10, -1.40, 1.75}};
  c.gimbal_gain = {1.01, 0.99, 1.0};
  c.gimbal_offset = {0.03, -0.02, 0.01};
  return c;
}

struct Bench {
  explicit Bench(HapticSettings settings = {}) : loop(arm, calibration(), {}, settings, input, output) {
    arm.sample.joints = {0.1, 0.5, 0.3};
    arm.sample.gimbal = {0.2, -0.1, 0.3};
  }
  void tick() {
    now += Duration(1'000'000);
    loop.tick(now);
  }
  // A tick with fresh input, as the physics loop gives it.
  void live() {
    input.write(message);
    tick();
  }
  FakeArm arm;
  TripleBuffer<HapticInput> input;
  TripleBuffer<TipState> output;
  HapticInput message;
  Instant<PhysicsClock> now;
  HapticLoop loop;
};

HapticSettings without_ramp() {
  HapticSettings settings;
  settings.limits.start_ramp_s = 0.0;
  return settings;
}

ContactEvent blow(std::uint64_t number, double speed, Instant<PhysicsClock> start) {
  ContactEvent event;
  event.number = number;
  event.start = start;
  event.duration = seconds(0.004);
  event.direction = Vector3(0.1, 0.3, 0.9).normalized();
  event.approach_speed = speed;
  event.mass = 0.0027;
  event.restitution = 0.8;
  return event;
}

TEST(HapticLoop, PublishesTheTipThroughTheCalibratedArm) {
  Bench bench;
  bench.live();
  TipState tip;
  ASSERT_TRUE(bench.output.read(tip));
  const auto c = calibration();
  const Vector3 theta(1.01 * 0.1, 0.99 * 0.5 + 0.02, 1.005 * 0.3 - 0.015);
  const auto expected = c.X_world_base * phantom_tip(theta, c.lengths);
  EXPECT_NEAR((tip.X_world_tip.translation - expected.m).norm(), 0.0, 1e-15);
  EXPECT_EQ(tip.time, bench.now);
}

TEST(HapticLoop, VelocityFollowsTheArmThroughCoarseEncoders) {
  Bench bench;
  const auto c = calibration();
  const auto theta_at = [](double t) {
    return Vector3(0.3 * std::sin(4 * t), 0.5 + 0.2 * std::sin(5 * t), 0.3);
  };
  double worst = 0.0;
  TipState tip;
  for (int i = 0; i < 1000; ++i) {
    const double t = 1e-3 * (i + 1), quantum = 1.4e-4;
    const Vector3 psi = c.correction.undo(theta_at(t));
    bench.arm.sample.joints = quantum * (psi / quantum).array().round().matrix();
    bench.live();
    bench.output.read(tip);
    if (i < 50) continue;
    const auto place = [&](double s) { return (c.X_world_base * phantom_tip(theta_at(s), c.lengths)).m; };
    const Vector3 v = (place(t + 1e-5) - place(t - 1e-5)) / 2e-5;
    worst = std::max(worst, (tip.velocity - v).norm());
  }
  EXPECT_LT(worst, 0.025);  // lag 2 ms times up to 3 m/s^2, and encoder steps
}

TEST(HapticLoop, TheWholeImpulseArrivesInTheRightDirectionThroughTheDevicesOwnKinematics) {
  for (const double speed : {0.5, 2.3, 12.0}) {
    for (const double phase : {0.0, 0.0003, 0.00077}) {
      Bench bench(without_ramp());
      for (int i = 0; i < 5; ++i) bench.live();
      bench.message.contact = blow(1, speed, bench.now + seconds(phase));
      const auto c = calibration();
      const Vector3 theta = c.correction.apply(bench.arm.sample.joints);
      // The motors' torques by the device's nominal arm, felt through the real one.
      const Matrix3 felt = phantom_jacobian(theta, c.lengths).transpose().inverse() *
                           phantom_jacobian(bench.arm.sample.joints, {}).transpose();
      Vector3 impulse = Vector3::Zero();
      for (int i = 0; i < 60; ++i) {
        bench.live();
        impulse += 1e-3 * (c.X_world_base.rotation * (felt * bench.arm.force));
        EXPECT_LE(bench.arm.force.norm(), 8.5);
      }
      const Vector3 asked = 0.0027 * 1.8 * speed * bench.message.contact.direction;
      EXPECT_NEAR((impulse - asked).norm() / asked.norm(), 0.0, 1e-9) << speed << " " << phase;
      const auto& s = bench.loop.statistics();
      EXPECT_EQ(s.blows, 1u);
      EXPECT_LT(s.impulse_error_rel_max, 1e-9);
      EXPECT_NEAR(s.impulse_asked, asked.norm(), 1e-15);
      EXPECT_LT(s.lost_impulse_rel(), 1e-9);
    }
  }
}

TEST(HapticLoop, ARepeatedMessageIsOneBlow) {
  Bench bench(without_ramp());
  bench.message.contact = blow(7, 1.0, bench.now);
  for (int i = 0; i < 40; ++i) bench.live();
  EXPECT_EQ(bench.loop.statistics().blows, 1u);
  bench.message.contact = blow(8, 1.0, bench.now);
  for (int i = 0; i < 40; ++i) bench.live();
  EXPECT_EQ(bench.loop.statistics().blows, 2u);
}

TEST(HapticLoop, ImpulseTheStartRampSwallowsIsCountedAsLost) {
  Bench bench;  // 1 s ramp
  bench.live();
  bench.message.contact = blow(1, 2.0, bench.now);
  for (int i = 0; i < 60; ++i) bench.live();
  EXPECT_GT(bench.loop.statistics().lost_impulse_rel(), 0.9);
}

TEST(HapticLoop, ASilentPhysicsLoopMeansNoForce) {
  Bench bench(without_ramp());
  bench.message.sustained = {0.0, 1.0, 0.0};
  for (int i = 0; i < 10; ++i) bench.live();
  EXPECT_NEAR(bench.arm.force.norm(), 1.0, 0.05);
  for (int i = 0; i < 30; ++i) bench.tick();
  EXPECT_EQ(bench.arm.force.norm(), 0.0);
  EXPECT_EQ(bench.loop.fault(), ForceFault::stale_input);
}

TEST(HapticLoop, ABadReadingFadesTheForceAndKeepsTheLastTip) {
  Bench bench(without_ramp());
  bench.message.sustained = {0.0, 1.0, 0.0};
  for (int i = 0; i < 10; ++i) bench.live();
  const Vector3 before = bench.loop.tip().X_world_tip.translation;
  bench.arm.sample.joints[1] = std::nan("");
  for (int i = 0; i < 30; ++i) {
    bench.live();
    ASSERT_TRUE(bench.arm.force.allFinite());
  }
  EXPECT_EQ(bench.arm.force.norm(), 0.0);
  EXPECT_EQ(bench.loop.tip().X_world_tip.translation, before);
  EXPECT_EQ(bench.loop.statistics().bad_samples, 30u);
}

TEST(HapticLoop, ABlowThatIsNoneIsRejected) {
  Bench bench(without_ramp());
  std::uint64_t number = 0;
  const auto reject = [&](auto&& spoil) {
    bench.message.contact = blow(++number, 1.0, bench.now);
    spoil(bench.message.contact);
    bench.live();
    EXPECT_EQ(bench.loop.statistics().rejected_blows, number);
  };
  reject([](ContactEvent& e) { e.mass = 0.0; });
  reject([](ContactEvent& e) { e.duration = Duration(0); });
  reject([](ContactEvent& e) { e.restitution = 1.5; });
  reject([](ContactEvent& e) { e.approach_speed = std::numeric_limits<double>::infinity(); });
  reject([](ContactEvent& e) { e.direction.setZero(); });
  EXPECT_EQ(bench.loop.statistics().blows, 0u);
}

TEST(HapticLoop, TickDoesNotAllocate) {
  Bench bench(without_ramp());
  Random random(1, "loop/alloc");
  bench.live();
  const std::size_t before = allocations();
  for (int i = 0; i < 3000; ++i) {
    if (i % 50 == 0) {
      bench.message.contact =
          blow(static_cast<std::uint64_t>(i / 50 + 1), random.uniform(0.1, 20.0), bench.now);
    }
    if (i % 500 < 450) {
      bench.live();
    } else {
      bench.tick();  // faults must not allocate either
    }
  }
  EXPECT_EQ(allocations() - before, 0u);
}

TEST(HapticLoop, TheLastSecondsAreKept) {
  HapticSettings settings;
  settings.record_s = 0.05;
  Bench bench(settings);
  for (int i = 0; i < 120; ++i) bench.live();
  const auto records = bench.loop.records();
  ASSERT_EQ(records.size(), 50u);
  EXPECT_EQ(records.back().time, bench.now);
  EXPECT_EQ(records.front().time, bench.now - Duration(49'000'000));
}

}  // namespace
}  // namespace palpate
