// A recording as devices: what its arm, its tracker or its cameras gave comes again at the pace at which it came, with the stamps
// it had. "recording:FILE" is the recording's arm, tracker or left camera; "recording:FILE#right" its right camera.
//
// The first sample comes at once when the device is opened. An arm takes no force. Devices are of one thread each, as ever; the
// tracker's and camera's are fed by a thread that reads ahead. Errors: refused where the recording has no such stream; at its end the
// camera's health is `recording_ended`, and arm and tracker say nothing any more.
#pragma once

#include <cstdint>
#include <functional>
#include <string_view>
#include <vector>

#include "palpate/device/driver_registry.h"

namespace palpate::record::session {

// Pixels of a JPEG file into an image's size and bytes; false where it is none.
using DecodeJpeg = std::function<bool(std::string_view bytes, device::CameraImage& image)>;

// `decode`: empty: only pictures that were recorded lossless can be seen.
void add_to(device::DriverRegistry& registry, DecodeJpeg decode = {});

}  // namespace palpate::record::session
