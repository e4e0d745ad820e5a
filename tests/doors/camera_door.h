// The laboratory's camera as a GigE Vision camera at 127.0.0.1, port 3956 (tests/fake_network_camera.h): each of its
// pictures goes out once, kCameraTakes after the laboratory could have had it.
//
// Stamped with the start of the exposure by the camera's own clock, and with its own count of frames. Pixels are what the
// client chooses: of a Bayer camera, RGB8 or Mono8.
#pragma once

#include <atomic>
#include <chrono>
#include <memory>
#include <string>

#include "drivers/laboratory/channel.h"
#include "palpate/time/instant.h"

namespace palpate::doors {

// What drawing may be late by before it shows to a client, who has no other way to tell it from the camera's own delay.
constexpr Duration kCameraTakes = std::chrono::milliseconds(250);

struct CameraDoorSettings {
  std::string serial;
  double exposure_s = 0.008, rate_hz = 30.0;  // what it tells of itself
};

// Until `stop`, or until the laboratory is gone, which is no error. `ready` is called once it can be found.
Expected<void> serve_camera(const std::shared_ptr<drivers::laboratory::LabClient>& laboratory,
                            const CameraDoorSettings& settings, const std::atomic<bool>& stop,
                            void (*ready)());

}  // namespace palpate::doors
