// When the machine itself stood still: on each core a thread that waits for the clock and for nothing else, as cyclictest
// does.
//
// With real-time rights it has a priority above the loops', so that what keeps it keeps everything on that core: a hypervisor
// that gives the core to others, or the kernel. Without them it is scheduled as everybody is, and "the machine" includes what
// else runs there.
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <thread>
#include <vector>

#include "palpate/haptics/trip_log.h"
#include "palpate/time/clock.h"

namespace palpate::server::physics {

struct MachineStall {
  Instant<PhysicsClock> from, to;  // it should have gone on, and did
  int core = 0;
};

class MachineStalls {
 public:
  static constexpr Duration kLook = std::chrono::milliseconds(4), kStall = std::chrono::milliseconds(5);
  static constexpr std::size_t kMostKept = 4096, kMostCores = 16;  // of each core; watched

  // Starts at once, on each core that this process may use. The clock must outlive it.
  MachineStalls(Clock<PhysicsClock>& clock, bool real_time);
  ~MachineStalls() { stop(); }
  MachineStalls(const MachineStalls&) = delete;
  MachineStalls& operator=(const MachineStalls&) = delete;

  void stop();
  // After stop(): all that were kept, by the time of their begin; and how many there were.
  const std::vector<MachineStall>& stalls() const { return stalls_; }
  std::uint64_t count() const { return count_; }
  Duration longest() const;

 private:
  struct Watch {
    std::vector<MachineStall> kept;
    std::uint64_t count = 0;
    std::thread thread;
  };
  void look(Watch& watch, Clock<PhysicsClock>& clock, int core, bool real_time);

  std::atomic<bool> stopping_{false};
  std::vector<std::unique_ptr<Watch>> watches_;
  std::vector<MachineStall> stalls_;
  std::uint64_t count_ = 0;
};

// Whether the machine stood still while forces were interrupted, or just before: within the 5 ms that a fault takes to be
// noticed.
bool within_stall(const haptics::LoggedTrip& trip, const std::vector<MachineStall>& stalls);

}  // namespace palpate::server::physics
