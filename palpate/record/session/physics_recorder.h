// Writes what the physics server's loops do into a recording: every tick, every step with its state, trips; and, sixty times a
// second, what a common viewer shows of it by itself (transforms, surfaces and bodies, a few numbers to plot). The surface that
// deforms, where there is one, is written thirty times a second.
//
// It looks at rings that the loops write, in a thread of its own or when its owner calls look(), so no loop ever waits for it;
// what it has missed because it came too late it counts. The physics clock is the machine's monotonic one, or computed
// (RecordingOptions). Recording, ticks and loop must outlive it.
#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <thread>
#include <vector>

#include "palpate/haptics/haptic_loop.h"
#include "palpate/record/session/physics_ticks.h"
#include "palpate/record/session/session_recording.h"
#include "palpate/record/session/shape_messages.h"
#include "palpate/rig/rig.h"
#include "palpate/scene/application.h"
#include "palpate/transport/state_service.h"

namespace palpate::record::session {

// How a loop is doing.
struct LoopFigures {
  std::string name;
  double rate_hz = 0.0;
  std::uint64_t ticks = 0, overruns = 0, missed = 0;
  double late_p50_us = 0.0, late_p99_us = 0.0, late_max_us = 0.0;
};

class PhysicsRecorder {
 public:
  // Rig and scene become attachments at once; `rig_text`: the file that `rig` was read from, empty: a text is made of it.
  PhysicsRecorder(SessionRecording& recording, const PhysicsTicks& ticks, const haptics::HapticLoop& loop,
                  const rig::Rig& rig, const scene::SceneDescription& scene,
                  const std::string& rig_text = {});
  ~PhysicsRecorder();  // stops
  PhysicsRecorder(const PhysicsRecorder&) = delete;
  PhysicsRecorder& operator=(const PhysicsRecorder&) = delete;

  // Before it begins: the surface of the scene's shape_vertices, where it has any.
  void record_shapes(transport::ShapeSource source);

  // Looks every 5 ms from now on.
  void start();
  // By whoever owns the time, where it was not started.
  void look();
  // Once the loops have ended: the rest is written.
  void stop();

  void write(const LoopFigures& loop, Instant<PhysicsClock> now);

  // Ticks and steps that were overwritten before it looked; after stop(), or in the thread that looks.
  std::uint64_t missed() const { return missed_; }

 private:
  void take_haptic_ticks();
  void take_steps();
  void take_trip();
  void take_shape();
  void show(const RecordedHapticTick& tick);
  void show_scene(std::uint64_t log_time);
  void show_bodies(const scene::SceneState& state, std::uint64_t log_time);
  void write(RecordStream& stream, Instant<PhysicsClock> time, std::string_view bytes) {
    const auto ns = recording_.log_time(time.ns());
    stream.write(ns, ns, bytes);
  }

  SessionRecording& recording_;
  const PhysicsTicks& ticks_;
  const haptics::HapticLoop& loop_;
  Pose<World, ArmBase> X_world_base_;
  scene::SceneDescription scene_;
  RecordStream &sample_, &force_, &step_, &state_, &trip_, &loops_, &tf_, &shown_scene_, &plot_;
  std::uint64_t haptic_next_ = 0, step_next_ = 0, missed_ = 0, trips_seen_ = 0;
  std::uint64_t next_show_ = 0, next_scene_ = 0, next_bodies_ = 0;
  transport::ShapeSource shape_source_;
  RecordStream* shapes_ = nullptr;  // null: no surface deforms
  ShapeEncoder shape_encoder_;
  scene::Shape shape_;
  Instant<PhysicsClock> last_step_, next_shape_;
  std::atomic<bool> stopping_{false};
  std::thread thread_;
};

}  // namespace palpate::record::session
