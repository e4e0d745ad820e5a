// Devices that are recorded: what a device gives to whoever uses it goes into the recording as well, with its own stamp and the
// host's time of arrival. Who uses the device notices nothing.
//
//   /arm/sample                    of an arm that is read by an ordinary thread (a haptic loop's: PhysicsRecorder)
//   /tracker/sample                each, seen or not
//   /camera/left, right/stamp      each image
//   /camera/left, right/image      its pixels, where that is asked for
//
// A device is used by one thread, as ever. Pictures are packed by a thread of the recording; what it cannot take is dropped and
// counted (a picture or two wait). Device and recording must outlive what is made of them.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>

#include "palpate/device/devices.h"
#include "palpate/record/session/session_recording.h"

namespace palpate::record::session {

struct PictureRecording {
  bool lossless = false;
  // As a JPEG file, of an image's pixels; any thread. Where it is empty and nothing is lossless, pictures are not recorded.
  std::function<std::string(const device::CameraImage&)> jpeg{};

  bool wanted() const { return lossless || jpeg != nullptr; }
};

// Of the clock that the recording's timeline is made of, ns.
using HostTime = std::function<std::int64_t()>;

std::unique_ptr<device::ArmDevice> recorded_device(device::ArmDevice& arm, SessionRecording& recording,
                                                   HostTime host_time);
std::unique_ptr<device::TrackerDevice> recorded_device(device::TrackerDevice& tracker,
                                                       SessionRecording& recording, HostTime host_time);
// `name`: "left" or "right".
std::unique_ptr<device::CameraDevice> recorded_device(device::CameraDevice& camera,
                                                      SessionRecording& recording,
                                                      const PictureRecording& pictures,
                                                      const std::string& name, HostTime host_time);

}  // namespace palpate::record::session
