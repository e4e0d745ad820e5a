// What a recording procedure works with: the devices, a person to ask, and the host's time to wait on.
//
// Real or simulated: a procedure cannot tell. References only; the owner of the devices outlives it. One
// thread.
#pragma once

#include "palpate/devices/devices.h"
#include "palpate/devices/person.h"
#include "palpate/time/clock.h"

namespace palpate {

struct Laboratory {
  Clock<PhysicsClock>& clock;
  ArmDevice& arm;
  TrackerDevice& tracker;
  CameraDevice* camera;  // null where a procedure needs none
  Person& person;
  CameraDevice* right_camera = nullptr;  // the second on the same marker; null where there is one
};

}  // namespace palpate
