// The simulated laboratory as a driver: "lab" or "lab:NAME" is the arm, the tracker, the camera, the hand and the
// display of the laboratory that `palpate world run --name NAME` serves.
#pragma once

#include <string>

#include "palpate/device/driver_registry.h"

namespace palpate::drivers::laboratory {

void add_to(device::DriverRegistry& registry);

// Whether there is a laboratory of that name to be opened; it may still be one that nobody serves any more.
bool is_there(const std::string& name);

}  // namespace palpate::drivers::laboratory
