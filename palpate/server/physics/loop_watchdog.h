// Stands beside the haptic loop: where a tick does not end, it makes the arm let go.
//
// A guest that never comes back takes the loop's thread with it, and with that everything the loop knows of
// fading. So a thread of its own looks at the count of ended ticks, with a priority above the loop's, and after
// kPatience calls HapticLoop::let_go(): the force is gone 24 ms after the last tick ended, whatever the driver
// makes of a command that nobody renews. When the loop comes back the rule for every return of force holds.
#pragma once

#include <atomic>
#include <thread>

#include "palpate/haptics/haptic_loop.h"
#include "palpate/time/standstill.h"

namespace palpate::server::physics {

// What the thread does, to be called by a test on a virtual clock.
class LoopWatch {
 public:
  static constexpr Duration kPatience = device::kLongestHold, kLook = std::chrono::milliseconds(4);

  explicit LoopWatch(haptics::HapticLoop& loop) : loop_(loop), standstill_(kPatience) {}
  // Every kLook. True while the loop hangs.
  bool look(Instant<PhysicsClock> now) {
    const bool hangs = standstill_.look(loop_.ticks_ended(), now);
    if (hangs) loop_.let_go();
    return hangs;
  }

 private:
  haptics::HapticLoop& loop_;
  Standstill<PhysicsClock> standstill_;
};

class LoopWatchdog {
 public:
  // Starts at once. Clock and loop must outlive it.
  LoopWatchdog(Clock<PhysicsClock>& clock, haptics::HapticLoop& loop, bool real_time);
  ~LoopWatchdog() { stop(); }
  LoopWatchdog(const LoopWatchdog&) = delete;
  LoopWatchdog& operator=(const LoopWatchdog&) = delete;

  void stop();
  // Any thread: whether a tick hangs now; how often one has.
  bool hangs() const { return hangs_.load(std::memory_order_relaxed); }
  std::uint64_t times() const { return times_.load(std::memory_order_relaxed); }

 private:
  std::atomic<bool> stopping_{false}, hangs_{false};
  std::atomic<std::uint64_t> times_{0};
  std::thread thread_;
};

}  // namespace palpate::server::physics
