// OpenIGTLink servers as trackers: "igtl://HOST[:PORT]".
#pragma once

#include "palpate/device/driver_registry.h"

namespace palpate::drivers::openigtlink {

void add_to(device::DriverRegistry& registry);

}  // namespace palpate::drivers::openigtlink
