// From the stamp that a camera gives to the middle of the exposure of its middle row, which is what a picture
// is stamped with here.
//
// With e the exposure time and r the time in which the rows are read out. Rolling shutter: row y of h is
// exposed from s + r y/h to s + r y/h + e, and the picture is complete at s + r + e. Global shutter: all rows
// from s to s + e, complete at s + e + r. Durations are of the camera's clock. What an interface does not
// tell (r, mostly) is 0 here: the constant that remains is part of the delay that `calibrate hand-eye` finds.
// What must not be left out is e, which changes with the light. Source: EMVA 1288, release 4.0 (2021), for
// the shutters.
#pragma once

#include "palpate/device/camera_settings.h"
#include "palpate/time/instant.h"

namespace palpate::drivers::cameras {

using device::StampAt;

struct Shutter {
  Duration exposure{0}, readout{0};
  bool rolling = false;
};

// To be added to the stamp.
inline Duration to_mid_exposure(StampAt at, const Shutter& shutter) {
  const Duration half =
      (shutter.exposure + (shutter.rolling ? shutter.readout : Duration(0))) / 2;  // s to middle
  switch (at) {
    case StampAt::exposure_start:
      return half;
    case StampAt::exposure_end:
      return half - shutter.exposure;
    case StampAt::frame_end:
      return half - shutter.exposure - shutter.readout;
    case StampAt::middle:
      break;
  }
  return Duration(0);
}

}  // namespace palpate::drivers::cameras
