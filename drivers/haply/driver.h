// Adds Haply's Inverse3 to the drivers of a program.
#pragma once

#include "palpate/device/driver_registry.h"

namespace palpate::drivers::haply {

void add_to(device::DriverRegistry& registry);

}  // namespace palpate::drivers::haply
