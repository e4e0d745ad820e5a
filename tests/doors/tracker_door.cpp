#include "tests/doors/tracker_door.h"

#include "drivers/openigtlink/protocol.h"
#include "palpate/device/live_name.h"
#include "palpate/time/clock.h"
#include "palpate/time/real_time.h"
#include "tests/doors/release.h"

namespace palpate::doors {
namespace {

// Often beside a millisecond: a tracker's period is a multiple of that, and what a sample waits here would be the same
// each time, and another at each start.
// After the laboratory's own tracker would have sent it.
constexpr Duration kTrackerTakes = std::chrono::milliseconds(3);
constexpr Duration kTrackerLook = std::chrono::microseconds(200);
constexpr int kTrackerPriority =
    50;  // a tracker's electronics wait for nobody; below those of arm and camera
constexpr Duration kOwnStart = std::chrono::seconds(1000);

}  // namespace

Expected<void> serve_tracker(const std::shared_ptr<drivers::laboratory::LabClient>& laboratory,
                             std::uint16_t port, const std::atomic<bool>& stop, void (*ready)()) {
  auto server = drivers::openigtlink::listen({"127.0.0.1", port});
  if (!server) return tl::unexpected(server.error());
  drivers::laboratory::LabTracker tracker(laboratory);
  MonotonicClock<TrueTime> clock;
  Release<device::TrackerSample> release(kTrackerTakes);
  enter_real_time(kTrackerPriority);
  ready();
  for (auto next = clock.now(); !stop && laboratory->alive(); next += kTrackerLook) {
    clock.sleep_until(next);
    const auto polled = tracker.poll();
    for (const auto& sample : polled)
      if (sample.seen) release.add(clock.now() - sample.waited, sample);
    while (const auto sample = release.take(clock.now())) {
      auto sent = (*server)->publish(device::live_name(sample->marker), sample->stamp + kOwnStart,
                                     {sample->rotation, sample->translation});
      if (!sent) return sent;
    }
  }
  return {};
}

}  // namespace palpate::doors
