// Drivers whose devices are recorded: what a device gives to whoever uses it goes into the recording as well, with its own stamp and
// the machine's time of arrival. Who uses the devices notices nothing.
//
//   /arm/sample                    of an arm that is read by an ordinary thread (a haptic loop's: PhysicsRecorder)
//   /tracker/sample                each, seen or not
//   /camera/left, right/stamp      each image; the first camera that is opened is the left one
//   /camera/left, right/image      its pixels, where that is asked for
//
// A device is used by one thread, as ever. Pictures are packed by a thread of the recording; what it cannot take is dropped and
// counted (a picture or two wait). The recording must outlive the devices.
#pragma once

#include <functional>
#include <string>

#include "palpate/device/driver_registry.h"
#include "palpate/record/session/session_recording.h"

namespace palpate::record::session {

struct PictureRecording {
  bool lossless = false;
  // As a JPEG file, of an image's pixels; any thread. Where it is empty and nothing is lossless, pictures are not recorded.
  std::function<std::string(const device::CameraImage&)> jpeg{};

  bool wanted() const { return lossless || jpeg != nullptr; }
};

device::DriverRegistry recorded_drivers(const device::DriverRegistry& drivers, SessionRecording& recording,
                                        const PictureRecording& pictures = {});

}  // namespace palpate::record::session
