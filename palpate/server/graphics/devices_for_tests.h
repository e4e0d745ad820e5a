// For tests: a camera and a tracker that give what they were handed, once, and a rig for them.
#pragma once

#include <optional>
#include <utility>
#include <vector>

#include "palpate/device/devices.h"
#include "palpate/rig/rig.h"

namespace palpate::server::graphics {

class HandedCamera : public device::CameraDevice {
 public:
  std::optional<device::CameraImage> next;
  std::vector<std::uint64_t> back;  // frames of images taken back
  std::optional<device::CameraImage> poll() override { return std::exchange(next, std::nullopt); }
  void take_back(device::CameraImage image) override { back.push_back(image.frame); }
};

class HandedTracker : public device::TrackerDevice {
 public:
  std::vector<device::TrackerSample> next;
  std::vector<device::TrackerSample> poll() override { return std::exchange(next, {}); }
};

inline rig::Rig calibrated_rig() {
  rig::Rig rig;
  rig.camera.emplace();
  rig.camera->model.width = 640, rig.camera->model.height = 480;
  rig.hand_eye.emplace();
  return rig;
}

}  // namespace palpate::server::graphics
