// The simulated laboratory as a driver: "lab" or "lab:NAME" is the arm, the tracker, the camera, the hand and the
// display of the laboratory that `palpate world run --name NAME` serves.
#pragma once

#include "palpate/device/driver_registry.h"

namespace palpate::drivers::laboratory {

void add_to(device::DriverRegistry& registry);

}  // namespace palpate::drivers::laboratory
