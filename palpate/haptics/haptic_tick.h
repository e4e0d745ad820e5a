// What a tick of the haptic loop was given and what it did: all that is needed to execute it again, and to compare.
#pragma once

#include <cstdint>

#include "palpate/device/devices.h"
#include "palpate/haptics/force_guard.h"
#include "palpate/haptics/guest.h"

namespace palpate::haptics {

struct HapticTick {
  std::uint64_t number = 0;     // 1, 2, ...
  Instant<PhysicsClock> begun;  // what tick() was called with
  device::ArmSample sample;     // as the arm's driver gave it
  // What came of it. Requested: on the hand, World, N; commanded: ArmBase, N.
  Vector3 tip = Vector3::Zero();  // World, m
  double speed = 0.0;             // of the tip, m/s
  Vector3 continuous = Vector3::Zero(), impact = Vector3::Zero(), commanded = Vector3::Zero();
  ForceState state = ForceState::ready;
  ForceFault fault = ForceFault::none;
  Guest culprit = Guest::none;
};

}  // namespace palpate::haptics
