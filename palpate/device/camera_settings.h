// What a person wants of a camera. Values.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

namespace palpate::device {

// What a camera's stamps mark; with the shutter it leads to the middle of the exposure.
enum class StampAt : std::uint8_t {
  exposure_start,  // GigE Vision and USB3 Vision as most cameras do, V4L2 with the flag SOE
  exposure_end,    // of the first row
  frame_end,       // V4L2 with the flag EOF; the time of arrival
  middle,          // nothing to correct: recorded sequences
};

// Zero or absent: as the camera is.
struct CameraSettings {
  int width = 0, height = 0;         // px; what the lens calibration was made for
  double rate_hz = 0.0;              // 0, or 1 to 1000
  std::optional<double> exposure_s;  // sets it by hand and switches its automatic off
  std::optional<double> gain;        // in the camera's own unit: dB for GenICam; switches its automatic off
  std::string pixel_format;          // as the driver writes it; empty: the best that both understand
  // Corrections where a data sheet knows better than the interface.
  std::optional<StampAt> stamp_at;
  double readout_s = 0.0;  // time in which the rows are read out
  bool rolling = false;    // shutter
  bool loop = false;       // a recording begins again at its end
};

}  // namespace palpate::device
