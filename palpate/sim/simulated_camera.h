// The simulated head camera: when it takes pictures, and when they arrive. Drawing them is another's work.
//
// The picture of a frame is that of its mid-exposure, stamped in the camera's clock; it arrives `latency`
// later. A dropped frame leaves a gap in the frame count. The picture is drawn only when somebody takes it.
// With a rolling shutter each band of rows has its own moment; the stamp is the middle of the picture. With
// more than one blur step a picture is the mean, in light, of so many moments of its exposure. One thread.
#pragma once

#include <deque>
#include <functional>
#include <string_view>

#include "palpate/core/random.h"
#include "palpate/device/devices.h"
#include "palpate/sim/config/world_file.h"
#include "palpate/sim/true_view.h"

namespace palpate::sim {

// Fills width * height * 3 bytes, row 0 on top.
using RenderView = std::function<void(const TrueView&, std::vector<std::uint8_t>&)>;

// A frame that is not drawn yet: may be drawn in another thread.
struct CameraShot {
  Instant<TrueTime> arrival;  // at the host
  Instant<CameraClock> mid_exposure;
  std::uint64_t frame = 0;
  int blur_steps = 1;           // views that are averaged, in light, to one band
  std::vector<TrueView> views;  // per band of rows, then per step of its exposure
};
// The shot as an image; without a renderer it has no pixels.
device::CameraImage draw_shot(const CameraShot& shot, const RenderView& render);

class SimulatedCamera {
 public:
  // `name` draws which of its frames are lost.
  SimulatedCamera(const config::WorldFile& world, std::uint64_t seed, std::string_view name = "camera");

  static constexpr int kRollingBands = 9;  // odd: the middle one is the stamp's
  int bands() const { return rolling_ ? kRollingBands : 1; }
  // The moments a picture is made of, bands and within each the steps of its exposure, and when they are,
  // relative to mid-exposure. The middle one is mid-exposure itself.
  int moments() const { return bands() * blur_steps_; }
  Duration moment_offset(int moment) const;

  // Mid-exposure of the next frame, true time.
  Instant<TrueTime> next_mid_exposure() const { return next_; }
  // The next frame is exposed now: `views` holds one view per moment. Drawn when taken.
  void expose(Instant<CameraClock> stamp, std::vector<TrueView> views);
  // Lets a frame pass without a view (nobody draws).
  void skip() { expose({}, {}); }

  // From the frame after the next on. Frames a second, more than 0.
  void set_rate(double rate_hz);

  // The newest frame that has arrived by `now`; older ones are forgotten.
  std::optional<CameraShot> take(Instant<TrueTime> now);
  // The newest frame that is exposed, on its way or arrived, for whoever needs the way's time to draw it.
  std::optional<CameraShot> take_exposed() { return take(Instant<TrueTime>{Duration::max()}); }

 private:
  double interval_s_ = 0.0;
  Duration latency_{0};
  double drop_ = 0.0, readout_s_ = 0.0, exposure_s_ = 0.0;
  int blur_steps_ = 1;
  bool rolling_ = false;
  std::uint64_t frame_ = 0;
  Instant<TrueTime> first_, next_;
  std::deque<CameraShot> pending_;
  Random drops_;
};

}  // namespace palpate::sim
