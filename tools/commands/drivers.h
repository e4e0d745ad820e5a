// The drivers of this program: the one place that names those that are built in.
#pragma once

#include "palpate/device/driver_registry.h"
#include "palpate/record/session/recording_driver.h"
#include "palpate/rig/rig.h"

namespace palpate::tools::commands {

device::DriverRegistry built_in_drivers();
// How recorded pictures are unpacked; empty in a physics server alone, which knows no pictures.
record::session::DecodeJpeg jpeg_decoder();
// The laboratory that stands in for what a desk has no device of: its arm, which the mouse moves. Refused, with what
// starts it, where `rig` of `file` is a desk's and the laboratory of that name is not there.
Expected<void> laboratory_of_desk(const rig::Rig& rig, const std::string& file,
                                  const std::string& laboratory);
// All there are, with those of the program's owner and of plug-ins (guests.h).
const device::DriverRegistry& drivers();

}  // namespace palpate::tools::commands
