// For tests: an arm, a tracker and a camera that stand still, on the machine's clock. They know nothing of each other.
#pragma once

#include <optional>
#include <vector>

#include "palpate/device/borrowed_devices.h"
#include "palpate/server/physics/rig_for_tests.h"
#include "palpate/time/clock.h"

namespace palpate::server::session {

class StillArm : public device::ArmDevice {
 public:
  device::ArmSample read() override {
    device::ArmSample sample;
    sample.stamp = clock_.now();
    sample.joints = {0.1, 0.5, 0.3};
    return sample;
  }
  void command(const Vector3&) override {}
  void let_go() noexcept override {}

 private:
  MonotonicClock<ArmClock> clock_;
};

class StillTracker : public device::TrackerDevice {
 public:
  std::vector<device::TrackerSample> poll() override {
    const auto now = clock_.now();
    if (now < next_) return {};
    next_ = now + std::chrono::milliseconds(10);
    device::TrackerSample sample;
    sample.stamp = now;
    sample.marker = device::MarkerId::camera_marker;
    sample.seen = true;
    sample.translation = kCamera;
    return {sample};
  }
  inline static const Vector3 kCamera{0.1, -0.2, -0.7};

 private:
  MonotonicClock<TrackerClock> clock_;
  Instant<TrackerClock> next_;
};

class StillCamera : public device::CameraDevice {
 public:
  std::optional<device::CameraImage> poll() override {
    const auto now = clock_.now();
    if (now < next_) return std::nullopt;
    next_ = now + std::chrono::milliseconds(20);
    return device::CameraImage{now, ++frame_, 640, 480, {}};
  }

 private:
  MonotonicClock<CameraClock> clock_;
  Instant<CameraClock> next_;
  std::uint64_t frame_ = 0;
};

class NoHand : public device::HandDevice {
 public:
  void move_to(const device::HandTarget&) override {}
};

// A laboratory of these, as the driver "still".
struct StillLaboratory {
  StillArm arm;
  StillTracker tracker;
  StillCamera camera;
  NoHand hand;

  device::DriverRegistry drivers() {
    device::DriverRegistry registry;
    registry.add(device::borrowed_devices(
        "still", {.arm = &arm,
                  .arm_facts = {.simulated = true, .identity = "still", .peak_n = {}, .continuous_n = {}},
                  .tracker = &tracker,
                  .camera = &camera,
                  .hand = &hand,
                  .simulated = true}));
    return registry;
  }
  static rig::Rig rig() {
    rig::Rig made = physics::rig_of_table_and_wall();
    made.camera.emplace();
    made.camera->model.width = 640;
    made.camera->model.height = 480;
    made.hand_eye.emplace();
    return made;
  }
};

}  // namespace palpate::server::session
