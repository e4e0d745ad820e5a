// Drivers whose devices are recorded (recorded_devices.h), with the machine's time of arrival. The first camera that is opened is
// the left one. The recording must outlive the devices.
#pragma once

#include "palpate/device/driver_registry.h"
#include "palpate/record/session/recorded_devices.h"

namespace palpate::record::session {

device::DriverRegistry recorded_drivers(const device::DriverRegistry& drivers, SessionRecording& recording,
                                        const PictureRecording& pictures = {});

}  // namespace palpate::record::session
