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

#include "palpate/device/devices.h"
#include "palpate/haptics/haptic_loop.h"
#include "palpate/rig/rig.h"
#include "palpate/scene/application.h"
#include "palpate/scene/scene_history.h"
#include "palpate/scene/shape_history.h"
#include "palpate/server/physics/delay_line.h"
#include "palpate/time/clock_model.h"

namespace palpate::server::physics {

class PhysicsServer {
 public:
  // Throws std::invalid_argument where the rig has no arm calibration. The arm must outlive the server.
  PhysicsServer(const rig::Rig& rig, const scene::SceneDescription& scene,
                std::unique_ptr<scene::Application> application, device::ArmDevice& arm,
                const haptics::HapticSettings& settings);

  // The haptic thread, 1 kHz. Forces that were switched off because the tip was too fast come back, ramped,
  // once the tip has been slow for half a second; after any other lasting fault (ForceGuard) a person's
  // `reset` re-arms. Every fault stays counted.
  void haptic_tick(Instant<PhysicsClock> now);
  // The physics thread, 1 kHz or faster.
  void physics_tick(Instant<PhysicsClock> now);
  // The physics thread: a person's wish.
  void control(scene::Control command) {
    if (command == scene::Control::reset) rearm_asked_.store(true, std::memory_order_relaxed);
    application_->control(command);
  }

  // Before the loops start: forces come so much later than they would (experiments). Throws
  // std::invalid_argument outside 0 ... DelayLine::kMost.
  void delay_forces(Duration delay);

  // Any thread.
  scene::StateAnswer state_at(Instant<PhysicsClock> time) const { return history_.at(time); }
  // Any thread: of the application's surface that deforms (ShapeHistory::at), where it has one.
  std::optional<Instant<PhysicsClock>> shape_at(Instant<PhysicsClock> time, std::span<float> out) const {
    return shapes_.at(time, out);
  }
  std::size_t shape_vertices() const { return shapes_.vertices(); }

  const haptics::HapticLoop& haptic() const { return haptic_; }
  // The physics thread's own view.
  const scene::SceneState& newest() const { return state_; }
  const scene::ImpactEvent& impact() const { return application_->impact(); }

 private:
  std::unique_ptr<scene::Application> application_;
  haptics::HapticInput felt_;  // of the newest step; physics thread
  DelayLine delay_line_;       // physics thread
  TripleBuffer<haptics::HapticInput> to_haptic_;
  TripleBuffer<scene::TipState> to_physics_;
  haptics::HapticLoop haptic_;
  scene::SceneHistory history_;
  scene::ShapeHistory shapes_;
  Instant<PhysicsClock> next_shape_;  // physics thread
  Instant<PhysicsClock> restless_;    // haptic thread: when there last was no calm after overspeed
  double calm_speed_;                 // m/s
  std::atomic<bool> rearm_asked_{false};
  scene::TipState tip_;
  scene::SceneState state_;
  std::optional<Instant<PhysicsClock>> last_;
};

// What both servers have to know about the scene: the rig's surfaces, which bounce a ball with `restitution`,
// and everything else as in `settings`.
scene::SceneDescription scene_from_rig(const rig::Rig& rig, scene::SceneDescription settings,
                                       double restitution);

}  // namespace palpate::server::physics
