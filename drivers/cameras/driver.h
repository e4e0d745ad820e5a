// Cameras and recordings of cameras as drivers: "aravis[:NAME]", "v4l2[:DEVICE]", "images:FOLDER", "video:FILE".
#pragma once

#include "palpate/device/driver_registry.h"

namespace palpate::drivers::cameras {

void add_to(device::DriverRegistry& registry);

}  // namespace palpate::drivers::cameras
