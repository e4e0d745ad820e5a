// Arms through the maker's OpenHaptics library as a driver: "openhaptics" is the default device,
// "openhaptics:NAME" that of the name which the maker's setup program gave.
#pragma once

#include "palpate/device/driver_registry.h"

namespace palpate::drivers::openhaptics {

void add_to(device::DriverRegistry& registry);

}  // namespace palpate::drivers::openhaptics
