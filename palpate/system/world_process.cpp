#include "palpate/system/world_process.h"

#include <fmt/format.h>

#include <condition_variable>
#include <mutex>
#include <optional>

#include "palpate/core/stop_signal.h"
#include "palpate/devices/lab_channel.h"
#include "palpate/sim/camera_renderer.h"
#include "palpate/sim/sim_world.h"

namespace palpate {
namespace {

using MonotonicTime = MonotonicClock<TrueTime>;

// A frame the camera has exposed and nobody has drawn yet.
struct Exposure {
  CameraImage image;  // stamp and size, no pixels
  std::vector<sim::TrueView> views;
  Instant<TrueTime> due;  // when it may arrive
};

// The newest exposure, from the world thread to the drawing thread. The world thread only tries the lock.
class ExposureSlot {
 public:
  void put(Exposure exposure) {
    std::unique_lock lock(mutex_, std::try_to_lock);
    if (!lock) return;  // the drawing thread is just taking one: this frame is dropped, as a camera would
    slot_ = std::move(exposure);
    lock.unlock();
    ready_.notify_one();
  }
  std::optional<Exposure> wait(std::chrono::milliseconds patience) {
    std::unique_lock lock(mutex_);
    ready_.wait_for(lock, patience, [this] { return slot_.has_value(); });
    return std::exchange(slot_, std::nullopt);
  }

 private:
  std::mutex mutex_;
  std::condition_variable ready_;
  std::optional<Exposure> slot_;
};

}  // namespace

Expected<WorldProcessResult> run_world_process(const WorldProcessOptions& options) {
  const auto& stop = stop_requested();
  LabSettings settings;
  settings.width = options.world.camera.size[0];
  settings.height = options.world.camera.size[1];
  auto opened = LabServer::open(options.lab, settings);
  if (!opened) return tl::unexpected(opened.error());
  LabServer& lab = **opened;

  // The world lets go of a frame at once; its latency is kept here, where drawing takes part of it.
  sim::WorldFile file = options.world;
  const Duration latency = seconds(file.camera.latency_s);
  file.camera.latency_s = 0.0;
  sim::SimWorld world(file, options.seed);

  ExposureSlot exposures;
  std::vector<sim::TrueView> seen;
  world.set_renderer([&seen](const sim::TrueView& view, std::vector<std::uint8_t>&) { seen.push_back(view); });

  WorldProcessResult result;
  MonotonicTime clock(0.0, 0.0);
  const Instant<TrueTime> start = clock.now();
  std::atomic<bool> ended{false};
  std::string failure;
  std::thread drawing([&] {
    name_and_pin_thread("palpate-draw", -1);
    try {
      sim::CameraRenderer renderer;
      while (!ended.load(std::memory_order_relaxed)) {
        auto exposure = exposures.wait(std::chrono::milliseconds(50));
        if (!exposure) continue;
        renderer.render(exposure->views[exposure->views.size() / 2], exposure->image.rgb);
        const Instant<TrueTime> due = start + exposure->due.since_epoch;
        if (clock.now() > due) ++result.late_images;
        clock.sleep_until(due);
        lab.publish_image(exposure->image);
        ++result.images;
      }
    } catch (const std::exception& error) {
      failure = error.what();
      ended = true;
    }
  });

  // A force command that nobody renews is a dead physics server: real drivers let go, and so does this one.
  constexpr Duration kForceKept = std::chrono::milliseconds(20);
  {
    PeriodicLoop<TrueTime> loop(clock, {.rate_hz = 1000.0, .name = "palpate-world", .real_time = options.real_time, .priority = 60, .spin = Duration(0)},
                                [&](Instant<TrueTime> deadline) {
                                  const auto force = lab.take_force();
                                  world.arm().command(force && force->age < kForceKept ? force->force : Vector3::Zero());
                                  if (const auto target = lab.take_hand_target()) world.hand().move_to(*target);
                                  world.advance_to({deadline - start});
                                  lab.publish_arm(world.arm().read());
                                  for (const auto& sample : world.tracker().poll()) lab.publish_tracker(sample);
                                  seen.clear();
                                  if (auto image = world.camera().poll(); image && !seen.empty()) {
                                    const Instant<TrueTime> taken = world.camera_clock().back(image->mid_exposure);
                                    exposures.put({std::move(*image), seen, taken + latency});
                                  }
                                  lab.heartbeat();
                                });
    while (!stop.load() && !ended.load() &&
           (options.seconds <= 0.0 || to_seconds(clock.now() - start) < options.seconds))
      std::this_thread::sleep_for(std::chrono::milliseconds(20));
    loop.stop();
    result.loop = loop.statistics();
  }
  ended = true;
  drawing.join();
  if (!failure.empty()) return refused("world: the camera's picture cannot be drawn: {}", failure);
  return result;
}

}  // namespace palpate
