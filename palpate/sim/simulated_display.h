// The simulated display: of a monitor that hangs beside the wall, the timecode's panel.
//
// It shows each timecode `scan_out` after it was handed over, until the next; a camera image shows the mean
// of what its exposure saw. The panel is painted over a finished image, with the lens, the vignette and the
// noise of the simulated camera, and is not there while nobody shows anything. It hangs where neither arm nor
// landmarks are; nothing is drawn in front of it. True time; World, m. One thread.
#pragma once

#include <deque>

#include "palpate/device/devices.h"
#include "palpate/device/timecode.h"
#include "palpate/sim/config/world_file.h"
#include "palpate/sim/lens_rays.h"
#include "palpate/sim/per_lens.h"
#include "palpate/sim/sensor_noise.h"
#include "palpate/sim/true_view.h"

namespace palpate::sim {

class SimulatedDisplay {
 public:
  explicit SimulatedDisplay(const config::WorldFile& world);

  // The timecode of time `code` is handed to the display; moments in their order.
  void show(Instant<TrueTime> at, Duration code);
  // Whether it shows anything then: it goes dark half a second after the last timecode.
  bool lit(Instant<TrueTime> at) const;
  // Mean light of the blocks over the exposure of an image, as its row number `row` of `rows` saw them.
  device::TimecodeLight light(Instant<TrueTime> mid_exposure, int row, int rows) const;

  // Paints the panel into an image taken with `view` at mid_exposure; all that the display showed then has to
  // be known by now.
  void paint(device::CameraImage& image, const TrueView& view, Instant<TrueTime> mid_exposure);

 private:
  struct Shown {
    Instant<TrueTime> at;  // its light
    Duration code{0};
  };
  Duration scan_out_, exposure_, readout_;
  std::deque<Shown> shown_;
  PerLens<LensRays> rays_;
  SensorNoise noise_{0.0};
};

}  // namespace palpate::sim
