// NDI trackers: "ndi://HOST[:PORT][/FILE.rom,...]".
#pragma once

#include "palpate/device/driver_registry.h"

namespace palpate::drivers::ndi {

void add_to(device::DriverRegistry& registry);

}  // namespace palpate::drivers::ndi
