// A haptic loop on an arm made for tests: readings and stamps as told, and every command judged.
#pragma once

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "palpate/haptics/haptic_loop.h"

namespace palpate::haptics {

inline rig::ArmCalibration bench_calibration() {
  rig::ArmCalibration c;
  c.correction.gain = {1.01, 0.99, 1.005};
  c.correction.offset = {0.0, 0.02, -0.015};
  c.X_world_base = {rotation_from_xyz({0.026, -0.07, 0.014}), {0.10, -1.40, 1.75}};
  c.gimbal_gain = {1.01, 0.99, 1.0};
  c.gimbal_offset = {0.03, -0.02, 0.01};
  return c;
}

class FakeArm : public device::ArmDevice {
 public:
  device::ArmSample read() override {
    if (!frozen) sample.stamp += Duration(1'000'000);
    sample.withheld += withheld_share * to_seconds(period) * force;
    if (lets_go) sample.held = force;
    return sample;
  }
  // As a device does when no command has come for kLongestHold, and says so.
  void let_go() noexcept override { force.setZero(); }
  void command(const Vector3& f) override {
    steepest = std::max(steepest, (f - force).norm());
    largest = std::max(largest, f.norm());
    finite = finite && f.allFinite();
    force = f;
  }
  // What the hand feels: motors' torques by the device's nominal arm, through the real one; World.
  Vector3 felt(const rig::ArmCalibration& c) const {
    const Vector3 theta = c.correction.apply(sample.joints);
    return c.X_world_base.rotation * (device::phantom_jacobian(theta, c.model.lengths).transpose().inverse() *
                                      device::phantom_jacobian(sample.joints, {}).transpose() * force);
  }
  device::ArmSample sample;
  bool frozen = false;
  bool lets_go = false;         // tells what it holds
  double withheld_share = 0.0;  // of each force, as the device itself reports
  Duration period{1'000'000};
  Vector3 force = Vector3::Zero();
  double steepest = 0.0, largest = 0.0;  // N, of all commands so far
  bool finite = true;
};

inline HapticSettings bench_settings() {
  HapticSettings settings;
  settings.permit = ForcePermit::of_simulated_arm();
  return settings;
}

struct HapticBench {
  explicit HapticBench(const HapticSettings& settings = bench_settings())
      : HapticBench(settings, bench_calibration()) {}
  HapticBench(const HapticSettings& settings, const rig::ArmCalibration& c)
      : period(settings.period), calibration(c), loop(arm, calibration, {}, settings, input, output) {
    arm.period = period;
    arm.sample.joints = {0.1, 0.5, 0.3};
    arm.sample.gimbal = {0.2, -0.1, 0.3};
  }
  void tick() {
    now += period;
    loop.tick(now);
  }
  // A tick with fresh input, as the physics loop gives it.
  void live() {
    message.time = now + period;
    input.write(message);
    tick();
  }
  void live(int ticks) {
    for (int i = 0; i < ticks; ++i) live();
  }
  // What the hand feels now, World, N.
  Vector3 felt() const { return arm.felt(calibration); }
  Duration period;
  rig::ArmCalibration calibration;
  FakeArm arm;
  TripleBuffer<HapticInput> input;
  TripleBuffer<scene::TipState> output;
  HapticInput message;
  Instant<PhysicsClock> now;
  HapticLoop loop;
};

inline HapticSettings without_ramp() {
  HapticSettings settings = bench_settings();
  settings.limits.start_ramp_s = 0.0;
  return settings;
}

inline scene::ImpactEvent bench_impact(std::uint64_t number, double speed, Instant<PhysicsClock> start) {
  scene::ImpactEvent event;
  event.number = number;
  event.start = start;
  event.duration = seconds(0.004);
  event.direction = Vector3(0.1, 0.3, 0.9).normalized();
  event.approach_speed = speed;
  event.mass = 0.0027;
  event.restitution = 0.8;
  return event;
}

}  // namespace palpate::haptics
