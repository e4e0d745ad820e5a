// Devices that a program has itself, as a driver: test doubles, a laboratory in the same process, a device that no
// driver opens. They are then named by URI like all others, and whoever opens devices need not know the difference.
//
// They belong to whoever made them, must outlive what is opened, and are each used by the thread that their
// interface says. Of a kind that is null none is offered.
#pragma once

#include <string>

#include "palpate/device/driver_registry.h"

namespace palpate::device {

struct BorrowedDevices {
  ArmDevice* arm = nullptr;
  ArmFacts arm_facts;
  TrackerDevice* tracker = nullptr;
  CameraDevice* camera = nullptr;
  CameraDevice* right_camera = nullptr;  // beside `camera`, by the same clock
  HandDevice* hand = nullptr;
  DisplayDevice* display = nullptr;
  bool simulated = false;  // camera and display: computed
};

// A driver whose only devices these are, each opened as `scheme`. DriverRegistry::add() refuses it where there is none.
Driver borrowed_devices(const std::string& scheme, const BorrowedDevices& devices);

}  // namespace palpate::device
