// The drivers of this program: the one place that names those that are built in.
#pragma once

#include "palpate/device/driver_registry.h"

namespace palpate::tools::commands {

device::DriverRegistry built_in_drivers();
// All there are, with those of the program's owner and of plug-ins (guests.h).
const device::DriverRegistry& drivers();

}  // namespace palpate::tools::commands
