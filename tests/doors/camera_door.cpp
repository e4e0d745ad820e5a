#include "tests/doors/camera_door.h"

#include <cmath>

#include "palpate/time/clock.h"
#include "tests/fake_network_camera.h"

namespace palpate::doors {
namespace {

constexpr Duration kPictureLook = std::chrono::milliseconds(1), kLongest = std::chrono::milliseconds(500);
// Of a picture's time: what drawing may be late by before it shows; less than two, so that none is overtaken.
constexpr double kHeld = 0.75;

// The pretended camera asks for a picture a little more often than there is one, and so waits for each.
constexpr double kFaster = 1.05;

class Pictures {
 public:
  Pictures(drivers::laboratory::LabCamera& camera, const CameraDoorSettings& settings)
      : camera_(camera),
        to_start_(seconds(-0.5 * settings.exposure_s)),
        held_(seconds(kHeld / settings.rate_hz)) {}

  // The next picture, a little after a camera would have brought it: one that took long to draw is as late as the others,
  // for the time that a camera takes does not depend on what else the machine does. The one before again where none has
  // come for long. Of the pretended camera's thread.
  FakeNetworkCamera::Shown next() {
    const auto until = clock_.now() + kLongest;
    while (clock_.now() < until) {
      if (auto image = camera_.poll()) {
        image_ = std::move(*image);
        clock_.sleep_until(clock_.now() - image_.waited + held_);
        break;
      }
      clock_.sleep_until(clock_.now() + kPictureLook);
    }
    return {&image_.rgb, static_cast<std::uint64_t>((image_.mid_exposure + to_start_).ns()), image_.frame};
  }

 private:
  drivers::laboratory::LabCamera& camera_;
  Duration to_start_, held_;
  device::CameraImage image_;
  MonotonicClock<TrueTime> clock_;
};

}  // namespace

Expected<void> serve_camera(const std::shared_ptr<drivers::laboratory::LabClient>& laboratory,
                            const CameraDoorSettings& settings, const std::atomic<bool>& stop,
                            void (*ready)()) {
  auto camera = drivers::laboratory::LabCamera::open(laboratory);
  if (!camera) return tl::unexpected(camera.error());
  Pictures pictures(**camera, settings);
  FakeNetworkCamera network(settings.serial, [&pictures] { return pictures.next(); });
  network.set_size();
  network.set(ARV_FAKE_CAMERA_REGISTER_EXPOSURE_TIME_US,
              static_cast<std::uint32_t>(std::lround(1e6 * settings.exposure_s)));
  network.set(ARV_FAKE_CAMERA_REGISTER_ACQUISITION_FRAME_PERIOD_US,
              static_cast<std::uint32_t>(std::lround(1e6 / (kFaster * settings.rate_hz))));
  ready();
  MonotonicClock<TrueTime> clock;
  while (!stop && laboratory->alive()) clock.sleep_until(clock.now() + std::chrono::milliseconds(50));
  return {};
}

}  // namespace palpate::doors
