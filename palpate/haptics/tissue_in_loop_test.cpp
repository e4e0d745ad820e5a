// A soft body through the whole haptic loop: encoders, kinematics, tip filter, contact law, limiter, observer,
// device's forces. A stylus of 75 g is thrown at it, or held lightly; forces act in the tick they are commanded in,
// or a tick later.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "palpate/device/phantom.h"
#include "palpate/haptics/haptic_bench_test.h"
#include "palpate/physics/tissue/tissue_for_tests.h"
#include "palpate/physics/tissue/tissue_law.h"

namespace palpate::haptics {
namespace {

namespace tissue = physics::tissue;

constexpr double kEncoder = 3e-5 / 0.20955;  // rad: steps of 0.03 mm at the tip
const tissue::SoftForTests kSoft;
const Vector3 kHalf(0.05, 0.04, 0.02);

const tissue::TipField& body_of(double tangent_n_m) {
  const auto built = [](double tangent) {
    // The box's corners, sharper than the lattice, are 1.4 times as stiff and set what is allowed.
    return *tissue::block_for_tests({.young = tissue::young_for_tests(tangent, 0.006)}, kHalf);
  };
  static const tissue::TipField soft = built(86.0), stiff = built(500.0);
  // What is hard inside makes it as stiff as is allowed where the stylus comes.
  static const tissue::TipField hard = [] {
    const auto above = [](double young) {
      return *tissue::block_for_tests(
          {.young = young, .share = tissue::bump_for_tests({0, 0, kHalf.z()}, 1.0, 0.008)}, kHalf);
    };
    return above(6000.0 * 0.999 * tissue::kMostTangent_n_m / above(6000.0).facts().stiffest_n_m);
  }();
  return tangent_n_m > 600.0 ? hard : tangent_n_m > 100.0 ? stiff : soft;
}

// Mass, damping and spring at the tip; joints read in steps.
class LightArm : public device::ArmDevice {
 public:
  explicit LightArm(const rig::ArmCalibration& calibration) : calibration_(calibration) {}
  device::ArmSample read() override {
    Vector3 theta;
    const auto X_base_world = calibration_.X_world_base.inverse();
    EXPECT_TRUE(
        device::phantom_inverse(X_base_world * Point<World>{place}, calibration_.model.lengths, theta));
    sample_.joints = Vector3((theta / kEncoder).array().round() * kEncoder);
    sample_.gimbal = Vector3::Zero();
    sample_.stamp += Duration(1'000'000);
    return sample_;
  }
  void command(const Vector3& f) override { commanded_ = calibration_.X_world_base.rotation * f; }
  void let_go() noexcept override { commanded_.setZero(); }
  // A millisecond with the command of this tick, or of the one before. Trapezoidal rule.
  void move() {
    const Vector3 force = late ? before_ : commanded_;
    before_ = commanded_;
    constexpr double kPlantStep = 1e-4;
    const double b = 0.5 * damping * kPlantStep, k = 0.25 * stiffness * kPlantStep * kPlantStep;
    for (int i = 0; i < 10; ++i) {
      const Vector3 old = velocity;
      velocity =
          ((mass - b - k) * old + kPlantStep * (force - stiffness * (place - target))) / (mass + b + k);
      place += 0.5 * kPlantStep * (old + velocity);
    }
  }
  double force() const { return commanded_.norm() + before_.norm(); }

  Vector3 place, velocity = Vector3::Zero(), target = Vector3::Zero();  // World
  double mass = 0.075, damping = 0.0, stiffness = 0.0;
  bool late = false;

 private:
  const rig::ArmCalibration& calibration_;
  device::ArmSample sample_;
  Vector3 commanded_ = Vector3::Zero(), before_ = Vector3::Zero();
};

struct SoftBench {
  SoftBench(const tissue::TipField& field, bool late)
      : touching((calibration.X_world_base * device::phantom_tip({0.1, 0.5, 0.3})).m),
        law(field, {}, {Quaternion::Identity(), touching - Vector3(0, 0, kHalf.z() + kSoft.radius)}) {
    arm.late = late;
    arm.place = touching;
  }
  static rig::ArmCalibration plain() {
    rig::ArmCalibration c;
    c.X_world_base = {Quaternion::Identity(), {0.10, -1.40, 1.75}};
    return c;
  }
  void live() {
    now += Duration(1'000'000);
    message.time = now;
    input.write(message);
    loop.tick(now);
    arm.move();
  }
  rig::ArmCalibration calibration = plain();
  Vector3 touching;  // where the tip just touches the body's top, World; the top faces +z
  tissue::TissueLaw law;
  LightArm arm{calibration};
  TripleBuffer<HapticInput> input;
  TripleBuffer<scene::TipState> output;
  HapticInput message;
  Instant<PhysicsClock> now;
  HapticLoop loop{arm, calibration, {}, without_ramp(), input, output, {"guest", &law, nullptr}};
};

TEST(TissueInTheHapticLoop, AFreeStylusNeverLeavesFasterThanItCame) {
  for (const double tangent : {86.0, 500.0, 700.0})
    for (const double speed : {0.05, 0.1, 0.3, 0.6, 1.0})
      for (const bool late : {false, true})
        for (int phase = 0; phase < 3; ++phase) {
          SoftBench bench(body_of(tangent), late);
          bench.arm.place = bench.touching + Vector3(0.001 * phase, 0.0, 0.004 + 3.7e-4 * speed * phase);
          bench.arm.velocity = speed * Vector3(0.3 * phase, 0.0, -1.0).normalized();
          double ratio = 0.0;
          bool touched = false, left = false;
          for (int i = 0; i < 1500 && !left; ++i) {
            bench.live();
            touched = touched || bench.law.newest().contact.depth > 0.0;
            const bool above = bench.arm.place.z() > bench.touching.z() + 1e-4;
            left = touched && above && bench.arm.velocity.z() > 0.0 && bench.arm.force() == 0.0;
            if (left) ratio = bench.arm.velocity.norm() / speed;
            if ((bench.arm.place - bench.touching).norm() > 0.05) break;
          }
          // The quickest goes through the softest: it is let go, and does not come back.
          EXPECT_EQ(left, tangent > 100.0 || speed < 1.0)
              << tangent << " N/m, " << speed << " m/s, late " << late;
          EXPECT_LE(ratio, 1.0) << tangent << " N/m, " << speed << " m/s, late " << late;
        }
}

TEST(TissueInTheHapticLoop, HeldLightlyItRestsWithinASecondOfBeingPressed) {
  for (const double tangent : {86.0, 500.0, 700.0})
    for (const bool late : {false, true}) {
      SoftBench bench(body_of(tangent), late);
      bench.arm.place = bench.touching + Vector3(0, 0, 0.0005);
      bench.arm.target = bench.touching - Vector3(0, 0, 0.004);
      bench.arm.stiffness = 250.0;
      bench.arm.damping = 0.2;
      double low = 1e9, high = -1e9;
      for (int i = 0; i < 2000; ++i) {
        bench.live();
        if (i < 1000) continue;
        low = std::min(low, bench.arm.place.z());
        high = std::max(high, bench.arm.place.z());
      }
      EXPECT_LT(high - low, 1e-4) << tangent << " late " << late;
      EXPECT_GT(bench.law.newest().contact.depth, 0.001);
      EXPECT_EQ(bench.loop.statistics().law_bad_forces, 0u);
    }
}

}  // namespace
}  // namespace palpate::haptics
