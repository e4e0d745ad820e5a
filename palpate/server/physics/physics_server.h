// The physics server: arm in, force out, the virtual world's states kept for whoever asks.
//
// Two loops. haptic_tick() reads the arm, knows the tip and commands the force; physics_tick() moves the
// virtual world on and stores its state. They meet in two triple buffers only, so each may run in a thread of
// its own at its own rate, or one after the other in lock-step. Neither locks, allocates, throws or calls the
// network. state_at() is for the network's threads. It knows no tracker and no camera, and builds without
// them.
//
// The application is a guest. Where it has a contact law the haptic tick evaluates that. One that throws is
// not called again, and forces fade as its state moves on no more; trouble() names it.
#pragma once

#include <array>
#include <atomic>
#include <exception>
#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "palpate/core/guest_call.h"
#include "palpate/device/devices.h"
#include "palpate/haptics/haptic_loop.h"
#include "palpate/record/session/physics_ticks.h"
#include "palpate/rig/rig.h"
#include "palpate/scene/application.h"
#include "palpate/scene/scene_history.h"
#include "palpate/scene/shape_history.h"
#include "palpate/time/clock_model.h"
#include "palpate/time/delay_line.h"

namespace palpate::server::physics {

class PhysicsServer {
 public:
  // Throws std::invalid_argument where the rig has no arm calibration, or the application's contact law makes
  // no sense. Arm and clock must outlive the server. `clock` measures what guests take in the haptic tick;
  // null, in lock-step: no time passes there.
  PhysicsServer(const rig::Rig& rig, const scene::SceneDescription& scene,
                std::unique_ptr<scene::Application> application, device::ArmDevice& arm,
                const haptics::HapticSettings& settings, const ThreadClock* clock = nullptr);

  // The haptic thread, 1 kHz. Forces that were switched off because the tip was too fast come back, ramped,
  // once the tip has been slow for half a second; after any other lasting fault (ForceGuard) a person's
  // `reset` re-arms. Every fault stays counted.
  // `told`, where it is asked for: what happened in it.
  void haptic_tick(Instant<PhysicsClock> now, haptics::HapticTick* told = nullptr);
  // The physics thread, 1 kHz or faster.
  void physics_tick(Instant<PhysicsClock> now);
  // The physics thread: a person's wish.
  void control(scene::Control command) {
    if (ticks_ != nullptr) ticks_->steps.control(command);
    const InputTrace::Scope scope(trace_of_step());
    if (command == scene::Control::reset) rearm_asked_.store(true, std::memory_order_relaxed);
    run_application([&] { application_->control(command); });
  }

  // Before the loops start: forces come so much later than they would (experiments). Throws
  // std::invalid_argument outside 0 ... DelayLine::kMost.
  void delay_forces(Duration delay);
  // Before the loops start: each tick and each step is written there, with all it has learned from outside its thread.
  // It must outlive the server.
  void record_to(record::session::PhysicsTicks& ticks) { ticks_ = &ticks; }

  // Any thread.
  // What has become of the application: empty, or that it threw and what. It stays so.
  std::string trouble() const;
  // The application, at most 64 bytes, where it or its law has brought the forces' fault about; else empty.
  std::string culprit() const;
  std::uint64_t steps_ended() const { return steps_ended_.load(std::memory_order_relaxed); }
  // Also a signal handler.
  void let_go() noexcept { haptic_.let_go(); }

  // Any thread. Steps whose tip is more than kLongestCarry old are not in the history, for up to 50 ms in a row: a gap in the arm's
  // readings is interpolated across once it is over, extrapolated into while it lasts.
  scene::StateAnswer state_at(Instant<PhysicsClock> time) const { return history_.at(time); }
  // Any thread: of the application's surface that deforms (ShapeHistory::at), where it has one.
  std::optional<Instant<PhysicsClock>> shape_at(Instant<PhysicsClock> time, std::span<float> out) const {
    return shapes_.at(time, out);
  }
  std::size_t shape_vertices() const { return shapes_.vertices(); }

  const haptics::HapticLoop& haptic() const { return haptic_; }
  haptics::HapticLoop& haptic() { return haptic_; }
  // The physics thread's own view, or after it has stopped; whoever else looks on has the server as const.
  const scene::SceneState& newest() { return state_; }
  const scene::ImpactEvent& impact() { return application_->impact(); }

 private:
  InputTrace* trace_of_step();
  bool move_on(Instant<PhysicsClock> now);
  bool shows_the_tip(Instant<PhysicsClock> now) const;
  void judge_calm(Instant<PhysicsClock> now);
  template <typename Call>
  void run_application(Call&& call);
  void fail(const char* what) noexcept;
  bool failed() const { return failed_.load(std::memory_order_acquire); }

  record::session::PhysicsTicks* ticks_ = nullptr;  // null: nobody records
  InputTrace haptic_trace_, step_trace_;            // of the tick under way, where somebody does
  bool step_traced_ = false;                        // its trace has begun, with a wish
  std::unique_ptr<scene::Application> application_;
  std::string application_name_, application_words_;
  std::array<char, 160> failure_{};  // what it threw; set before `failed_`
  std::atomic<bool> failed_{false};
  std::atomic<std::uint64_t> steps_ended_{0};
  haptics::HapticInput felt_;                   // of the newest step; physics thread
  DelayLine<haptics::HapticInput> delay_line_;  // physics thread
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
  bool tip_known_ = false;
  scene::SceneState state_;
  std::optional<Instant<PhysicsClock>> last_;
};

// One that has thrown is not called again: nobody knows what it has left half done.
template <typename Call>
void PhysicsServer::run_application(Call&& call) {
  if (failed()) return;
  const GuestCall named(application_words_.c_str());
  try {
    call();
  } catch (const std::exception& e) {
    fail(e.what());
  } catch (...) {
    fail("what is no std::exception");
  }
}

// What both servers have to know about the scene: the rig's surfaces and arm, and everything else as the application
// described it.
scene::SceneDescription scene_from_rig(const rig::Rig& rig, scene::SceneDescription described);

}  // namespace palpate::server::physics
