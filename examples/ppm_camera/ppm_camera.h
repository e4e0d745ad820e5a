// A camera driver: "ppm:PATH" takes the pictures that another program writes into a pipe at PATH, one binary PPM after
// the other. With ffmpeg behind it, that is every source ffmpeg reads: network cameras, frame grabbers, screens.
//
//   mkfifo eye && ffmpeg -i rtsp://camera/1 -f image2pipe -c:v ppm -y eye
//
// A picture is stamped when its last byte has come, by this machine's monotonic clock: later than it was exposed, by as
// much as the way takes; hand-eye calibration finds that delay.
#pragma once

#include "palpate/device/driver_registry.h"

namespace ppm {

palpate::device::Driver driver();

}  // namespace ppm
