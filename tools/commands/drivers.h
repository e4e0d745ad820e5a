// The drivers of this program: the one place that names them.
#pragma once

#include "palpate/device/driver_registry.h"

namespace palpate::tools::commands {

const device::DriverRegistry& drivers();

}  // namespace palpate::tools::commands
