// A physics side in real time: the haptic loop and the physics loop in threads of their own, and who watches over
// them: a watchdog beside the haptic loop, watches of the machine's own stalls, and the crash that makes the arm let go before the process ends.
//
// Made, looked at and stopped by one ordinary thread; stopped at the latest by its end.
#pragma once

#include <optional>

#include "palpate/server/physics/loop_watchdog.h"
#include "palpate/server/physics/machine_stalls.h"
#include "palpate/server/physics/physics_side.h"
#include "palpate/time/clock.h"
#include "palpate/time/periodic_loop.h"

namespace palpate::server::physics {

struct LoopRates {
  double physics_hz = 1000.0, haptic_hz = 1000.0;
  bool real_time = true;  // ask for SCHED_FIFO; the loops run without it as well
};

class PhysicsLoops {
 public:
  // They start at once. Side and clock must outlive them; one object of this class at a time in a process.
  PhysicsLoops(PhysicsSide& side, Clock<PhysicsClock>& clock, const LoopRates& rates);
  ~PhysicsLoops() { stop(); }
  PhysicsLoops(const PhysicsLoops&) = delete;
  PhysicsLoops& operator=(const PhysicsLoops&) = delete;

  // Returns when they have ended.
  void stop();

  // Writes down for whoever asks how they are doing, `up_s` after their start.
  void write_status(double up_s, const std::optional<transport::RecordingStatus>& recording = {});

  const PeriodicLoop<PhysicsClock>& haptic() const { return haptic_; }
  const PeriodicLoop<PhysicsClock>& physics() const { return physics_; }
  const LoopWatchdog& watchdog() const { return watchdog_; }
  const MachineStalls& machine_stalls() const { return stalls_; }

 private:
  PhysicsSide& side_;
  PeriodicLoop<PhysicsClock> haptic_, physics_;
  LoopWatchdog watchdog_;
  MachineStalls stalls_;
};

}  // namespace palpate::server::physics
