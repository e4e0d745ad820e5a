// What a recording procedure works with: the devices, a person to ask, and the host's time to wait on.
//
// Real or simulated: a procedure cannot tell, but for the one that commands forces. References only; the owner of the devices outlives it. One
// thread.
#pragma once

#include <atomic>

#include "palpate/device/devices.h"
#include "palpate/device/person.h"
#include "palpate/time/clock.h"

namespace palpate::calibration::session {

struct AcquisitionContext {
  Clock<PhysicsClock>& clock;
  device::ArmDevice& arm;
  device::TrackerDevice& tracker;
  device::CameraDevice* camera;  // null where a procedure needs none
  device::Person& person;
  device::CameraDevice* right_camera = nullptr;  // the second on the same marker; null where there is one
  // The arm is a computed one: its forces, which nothing limits here, hurt nobody.
  bool computed_arm = false;
  // Becomes true: what is being recorded is given up. Null: nobody breaks off.
  const std::atomic<bool>* stop = nullptr;

  bool stopped() const { return stop != nullptr && stop->load(std::memory_order_relaxed); }
};

}  // namespace palpate::calibration::session
