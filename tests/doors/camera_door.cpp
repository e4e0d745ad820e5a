#include "tests/doors/camera_door.h"

#include <cmath>
#include <deque>
#include <mutex>
#include <optional>
#include <thread>
#include <utility>

#include "palpate/time/clock.h"
#include "palpate/time/clock_model.h"
#include "palpate/time/real_time.h"
#include "tests/fake_camera_clock.h"
#include "tests/fake_network_camera.h"

namespace palpate::doors {
namespace {

constexpr Duration kPictureLook = std::chrono::milliseconds(1), kLongest = std::chrono::milliseconds(500),
                   kGoneBy = std::chrono::milliseconds(100), kSettles = std::chrono::seconds(5);

// A camera's electronics wait for nobody; not above those of an arm.
constexpr int kElectronics = 60;

// The pretended camera asks for a picture a little more often than there is one, and so waits for each.
constexpr double kFaster = 1.05;

// The clock of the laboratory's camera beside this machine's, as its pictures tell: all of them are as late as the
// laboratory's camera makes them, to the ns. What that is stays in it, the same for all who ask.
class LabCameraClock {
 public:
  void add(Instant<CameraClock> stamp, Instant<TrueTime> arrived) {
    const std::lock_guard lock(mutex_);
    clock_.add(stamp, arrived);
  }
  // Nobody is told a clock that is still being learned.
  bool settled() const {
    const std::lock_guard lock(mutex_);
    return clock_.phase() == ClockPhase::tracking;
  }
  std::uint64_t now_ns() const {
    const std::lock_guard lock(mutex_);
    return static_cast<std::uint64_t>(clock_.model().back(machine_.now()).ns());
  }

 private:
  MonotonicClock<TrueTime> machine_;
  mutable std::mutex mutex_;
  ClockEstimator<CameraClock, TrueTime> clock_;
};

// Takes the laboratory's pictures as they are drawn, and gives each a fixed time after its exposure: one that took long to draw is as
// late as the others, for the time that a camera takes does not depend on what else the machine does.
class Pictures {
 public:
  Pictures(drivers::laboratory::LabCamera& camera, LabCameraClock& camera_clock,
           const CameraDoorSettings& settings)
      : camera_clock_(camera_clock),
        to_start_(seconds(-0.5 * settings.exposure_s)),
        taking_([this, &camera] { take(camera); }) {}
  ~Pictures() {
    stop_ = true;
    taking_.join();
  }

  // The next picture, to be made ready before it is due; the one before again where none has come for long. Of the
  // pretended camera's thread.
  FakeNetworkCamera::Shown next() {
    if (!hurried_) enter_real_time(kElectronics);
    hurried_ = true;
    const auto until = clock_.now() + kLongest;
    auto release = clock_.now();
    while (clock_.now() < until) {
      if (auto waiting = taken()) {
        release = waiting->first;
        image_ = std::move(waiting->second);
        break;
      }
      clock_.sleep_until(clock_.now() + kPictureLook);
    }
    return {&image_.rgb, static_cast<std::uint64_t>((image_.mid_exposure + to_start_).ns()), image_.frame,
            [this, release] { clock_.sleep_until(release); }};
  }

 private:
  using Waiting = std::pair<Instant<TrueTime>, device::CameraImage>;  // with the time of its release

  void take(drivers::laboratory::LabCamera& camera) {
    while (!stop_) {
      if (auto image = camera.poll()) {
        const auto arrived = clock_.now() - image->waited;
        camera_clock_.add(image->mid_exposure, arrived);
        const auto release = arrived + kCameraTakes;
        const std::lock_guard lock(mutex_);
        waiting_.emplace_back(release, std::move(*image));
        while (!waiting_.empty() && clock_.now() - waiting_.front().first > kGoneBy) waiting_.pop_front();
      }
      clock_.sleep_until(clock_.now() + kPictureLook);
    }
  }

  // While nobody looks pictures go by, as those of a camera do; whoever begins to look gets the next.
  std::optional<Waiting> taken() {
    const std::lock_guard lock(mutex_);
    while (waiting_.size() > 1 && clock_.now() - waiting_.front().first > kGoneBy) waiting_.pop_front();
    if (waiting_.empty()) return std::nullopt;
    auto oldest = std::move(waiting_.front());
    waiting_.pop_front();
    return oldest;
  }

  LabCameraClock& camera_clock_;
  Duration to_start_;
  MonotonicClock<TrueTime> clock_;
  std::mutex mutex_;
  std::deque<Waiting> waiting_;
  device::CameraImage image_;  // of the pretended camera's thread
  bool hurried_ = false;
  std::atomic<bool> stop_{false};
  std::thread taking_;
};

}  // namespace

Expected<void> serve_camera(const std::shared_ptr<drivers::laboratory::LabClient>& laboratory,
                            const CameraDoorSettings& settings, const std::atomic<bool>& stop,
                            void (*ready)()) {
  auto camera = drivers::laboratory::LabCamera::open(laboratory);
  if (!camera) return tl::unexpected(camera.error());
  LabCameraClock camera_clock;
  set_fake_camera_clock([&camera_clock] { return camera_clock.now_ns(); });
  Pictures pictures(**camera, camera_clock, settings);
  MonotonicClock<TrueTime> clock;
  const auto patience = clock.now() + kSettles;
  while (!stop && !camera_clock.settled() && clock.now() < patience)
    clock.sleep_until(clock.now() + kPictureLook);
  FakeNetworkCamera network(settings.serial, [&pictures] { return pictures.next(); });
  network.set_size();
  network.set(ARV_FAKE_CAMERA_REGISTER_EXPOSURE_TIME_US,
              static_cast<std::uint32_t>(std::lround(1e6 * settings.exposure_s)));
  network.set(ARV_FAKE_CAMERA_REGISTER_ACQUISITION_FRAME_PERIOD_US,
              static_cast<std::uint32_t>(std::lround(1e6 / (kFaster * settings.rate_hz))));
  ready();
  while (!stop && laboratory->alive()) clock.sleep_until(clock.now() + std::chrono::milliseconds(50));
  return {};
}

}  // namespace palpate::doors
