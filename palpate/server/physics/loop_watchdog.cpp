#include "palpate/server/physics/loop_watchdog.h"

#include "palpate/time/real_time.h"

namespace palpate::server::physics {

LoopWatchdog::LoopWatchdog(Clock<PhysicsClock>& clock, haptics::HapticLoop& loop, bool real_time) {
  thread_ = std::thread([this, &clock, &loop, real_time] {
    name_and_pin_thread("palpate-watch", -1);
    constexpr int kAboveTheLoops = 90;
    if (real_time) enter_real_time(kAboveTheLoops);
    LoopWatch watch(loop);
    bool before = false;
    while (!stopping_.load(std::memory_order_relaxed)) {
      const bool hangs = watch.look(clock.now());
      if (hangs && !before) times_.fetch_add(1, std::memory_order_relaxed);
      hangs_.store(hangs, std::memory_order_relaxed);
      before = hangs;
      clock.sleep_until(clock.now() + LoopWatch::kLook);
    }
  });
}

void LoopWatchdog::stop() {
  stopping_.store(true, std::memory_order_relaxed);
  if (thread_.joinable()) thread_.join();
}

}  // namespace palpate::server::physics
