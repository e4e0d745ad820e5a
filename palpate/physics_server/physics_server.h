// The physics server: arm in, force out, the virtual world's states kept for whoever asks.
//
// Two loops. haptic_tick() reads the arm, knows the tip and commands the force; physics_tick() moves the
// virtual world on and stores its state. They meet in two triple buffers only, so each may run in a thread of
// its own at its own rate, or one after the other in lock-step. Neither locks, allocates, throws or calls the
// network. state_at() is for the network's threads. It knows no tracker and no camera, and builds without
// them.
#pragma once

#include <atomic>
#include <functional>
#include <memory>
#include <optional>

#include "palpate/devices/devices.h"
#include "palpate/haptics/haptic_loop.h"
#include "palpate/model/rig.h"
#include "palpate/physics_server/delay_line.h"
#include "palpate/scene/application.h"
#include "palpate/scene/shape_history.h"
#include "palpate/scene/world_history.h"
#include "palpate/time/clock_model.h"

namespace palpate {

class PhysicsServer {
 public:
  // Throws std::invalid_argument where the rig has no arm calibration. The arm must outlive the server.
  PhysicsServer(const Rig& rig, const SceneDescription& scene, std::unique_ptr<Application> application,
                ArmDevice& arm, const HapticSettings& settings);

  // The haptic thread, 1 kHz. Forces that were switched off because the tip was too fast come back, ramped,
  // once the tip has been slow for half a second; after any other lasting fault (ForceGuard) a person's
  // `reset` re-arms. Every fault stays counted.
  void haptic_tick(Instant<PhysicsClock> now);
  // The physics thread, 1 kHz or faster.
  void physics_tick(Instant<PhysicsClock> now);
  // The physics thread: a person's wish.
  void control(Control command) {
    if (command == Control::reset) rearm_asked_.store(true, std::memory_order_relaxed);
    application_->control(command);
  }

  // Before the loops start: forces come so much later than they would (experiments). Throws
  // std::invalid_argument outside 0 ... DelayLine::kMost.
  void delay_forces(Duration delay);

  // Any thread.
  StateAnswer state_at(Instant<PhysicsClock> time) const { return history_.at(time); }
  // Any thread: of the application's surface that deforms (ShapeHistory::at), where it has one.
  std::optional<Instant<PhysicsClock>> shape_at(Instant<PhysicsClock> time, std::span<float> out) const {
    return shapes_.at(time, out);
  }
  std::size_t shape_vertices() const { return shapes_.vertices(); }

  const HapticLoop& haptic() const { return haptic_; }
  // The physics thread's own view.
  const WorldState& newest() const { return state_; }
  const ContactEvent& contact() const { return application_->contact(); }

 private:
  std::unique_ptr<Application> application_;
  HapticInput felt_;      // of the newest step; physics thread
  DelayLine delay_line_;  // physics thread
  TripleBuffer<HapticInput> to_haptic_;
  TripleBuffer<TipState> to_physics_;
  HapticLoop haptic_;
  WorldHistory history_;
  ShapeHistory shapes_;
  Instant<PhysicsClock> next_shape_;  // physics thread
  int calm_ticks_ = 0;                // haptic thread
  double calm_speed_;                 // m/s
  std::atomic<bool> rearm_asked_{false};
  TipState tip_;
  WorldState state_;
  std::optional<Instant<PhysicsClock>> last_;
};

// What both servers have to know about the scene: the rig's surfaces, which bounce a ball with `restitution`,
// and everything else as in `settings`.
SceneDescription scene_from_rig(const Rig& rig, SceneDescription settings, double restitution);

}  // namespace palpate
