// VRPN servers as trackers: "vrpn://HOST[:PORT]".
#pragma once

#include "palpate/device/driver_registry.h"

namespace palpate::drivers::vrpn {

void add_to(device::DriverRegistry& registry);

}  // namespace palpate::drivers::vrpn
