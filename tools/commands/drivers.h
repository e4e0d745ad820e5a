// The drivers of this program: the one place that names those that are built in.
#pragma once

#include "palpate/device/driver_registry.h"
#include "palpate/record/session/recording_driver.h"

namespace palpate::tools::commands {

device::DriverRegistry built_in_drivers();
// How recorded pictures are unpacked; empty in a physics server alone, which knows no pictures.
record::session::DecodeJpeg jpeg_decoder();
// All there are, with those of the program's owner and of plug-ins (guests.h).
const device::DriverRegistry& drivers();

}  // namespace palpate::tools::commands
