#include "palpate/server/physics/physics_loops.h"

#include "palpate/core/crash_words.h"

namespace palpate::server::physics {

// The physics loop sleeps only: two loops that spin would starve each other on a small machine.
PhysicsLoops::PhysicsLoops(PhysicsSide& side, Clock<PhysicsClock>& clock, const LoopRates& rates)
    : side_(side),
      haptic_(clock,
              PeriodicLoopSettings{.rate_hz = rates.haptic_hz,
                                   .name = "palpate-haptic",
                                   .real_time = rates.real_time,
                                   .priority = 80,
                                   .keep_cores_awake = true},
              [&side](Instant<PhysicsClock> t) { side.haptic_tick(t); }),
      physics_(clock,
               PeriodicLoopSettings{.rate_hz = rates.physics_hz,
                                    .name = "palpate-physics",
                                    .real_time = rates.real_time,
                                    .priority = 70,
                                    .spin = Duration(0)},
               [&side](Instant<PhysicsClock> t) { side.physics_tick(t); }),
      watchdog_(clock, side.server().haptic(), rates.real_time),
      stalls_(clock, rates.real_time) {
  say_crashes([](void* server) noexcept { static_cast<PhysicsServer*>(server)->let_go(); }, &side.server());
}

void PhysicsLoops::stop() {
  stalls_.stop();
  watchdog_.stop();
  haptic_.stop();
  physics_.stop();
  say_crashes(nullptr, nullptr);  // nothing touches the arm any more that could let go of it
}

void PhysicsLoops::write_status(double up_s, const std::optional<transport::RecordingStatus>& recording) {
  transport::LoopStatus force_loop = transport::loop_status("haptic", haptic_);
  const haptics::HapticCondition condition = side_.server().haptic().condition();
  force_loop.forces = device::ForceCondition{condition.state, condition.fault};
  force_loop.culprit = side_.server().culprit();
  force_loop.peak_n = side_.server().haptic().limits().peak_n;
  force_loop.continuous_n = side_.server().haptic().limits().continuous_n;
  force_loop.trips = condition.trips;
  side_.board().write({.uptime_s = up_s,
                       .failure = side_.server().trouble(),
                       .loops = {std::move(force_loop), transport::loop_status("physics", physics_)},
                       .recording = recording});
}

}  // namespace palpate::server::physics
