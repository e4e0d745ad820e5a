// Offers arms of Force Dimension and Novint's Falcon under "forcedimension". Once, from one thread.
#pragma once

#include "palpate/device/driver_registry.h"

namespace palpate::drivers::forcedimension {

void add_to(device::DriverRegistry& registry);

}  // namespace palpate::drivers::forcedimension
