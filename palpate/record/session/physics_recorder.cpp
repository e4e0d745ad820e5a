#include "palpate/record/session/physics_recorder.h"

#include <algorithm>
#include <chrono>

#include "foxglove.pb.h"
#include "palpate/core/log.h"
#include "palpate/record/session/internal/message_parts.h"
#include "palpate/record/session/internal/viewer_messages.h"
#include "palpate/record/session/tick_messages.h"
#include "palpate/record/session/viewer_feed.h"
#include "palpate/transport/messages.h"
#include "palpate/transport/wire_numbers.h"

namespace palpate::record::session {
namespace {

constexpr Log kRecorderLog("recording");
constexpr std::uint64_t kShowEvery = 1'000'000'000 / 60, kSceneEvery = 5'000'000'000;  // ns
constexpr Duration kShapeEvery = std::chrono::nanoseconds(1'000'000'000 / 30);

// Takes entries from `next` on; those that are gone count as missed.
template <typename Ring, typename Take>
void drain(const Ring& ring, std::uint64_t& next, std::uint64_t& missed, Take&& take) {
  const std::uint64_t count = ring.count();
  if (count - next > ring.capacity()) {
    missed += count - next - ring.capacity();
    next = count - ring.capacity();
  }
  for (; next < count; ++next) {
    const auto entry = ring.read(next);
    if (entry)
      take(*entry);
    else
      ++missed;
  }
}

}  // namespace

PhysicsRecorder::PhysicsRecorder(SessionRecording& recording, const PhysicsTicks& ticks,
                                 const haptics::HapticLoop& loop, const rig::Rig& rig,
                                 const scene::SceneDescription& scene, const std::string& rig_text)
    : recording_(recording),
      ticks_(ticks),
      loop_(loop),
      X_world_base_(rig.arm ? rig.arm->X_world_base : Pose<World, ArmBase>{}),
      scene_(scene),
      sample_(recording.stream("/arm/sample", "palpate.recording.ArmSample")),
      force_(recording.stream("/arm/force", "palpate.recording.ArmForce")),
      step_(recording.stream("/physics/step", "palpate.recording.PhysicsStep")),
      state_(recording.stream("/physics/state", "palpate.wire.WorldState")),
      trip_(recording.stream("/trip", "palpate.recording.Trip")),
      loops_(recording.stream("/loop", "palpate.recording.Loop")),
      tf_(recording.stream("/tf", "foxglove.FrameTransforms")),
      shown_scene_(recording.stream("/scene", "foxglove.SceneUpdate")),
      plot_(recording.stream("/plot", "palpate.recording.Plot")) {
  for (const auto& done :
       {recording.attach("rig.toml", "application/toml", rig_text.empty() ? rig::rig_text(rig) : rig_text),
        recording.attach("scene.pb", "application/x-protobuf; palpate.wire.SceneDescription",
                         transport::encode(scene))})
    if (!done) kRecorderLog.warning("warning: {}", done.error().message);
}

PhysicsRecorder::~PhysicsRecorder() { stop(); }

void PhysicsRecorder::record_shapes(transport::ShapeSource source) {
  if (scene_.shape_vertices == 0) return;
  shape_source_ = std::move(source);
  shapes_ = &recording_.stream("/physics/shape", "palpate.recording.Shape");
  shape_.values.resize(scene_.shape_vertices * scene::Shape::kFloatsPerVertex);
}

void PhysicsRecorder::start() {
  thread_ = std::thread([this] {
    while (!stopping_.load()) {
      look();
      std::this_thread::sleep_for(std::chrono::milliseconds(5));
    }
  });
}

void PhysicsRecorder::stop() {
  stopping_.store(true);
  if (thread_.joinable()) thread_.join();
  look();
}

void PhysicsRecorder::look() {
  take_haptic_ticks();
  take_steps();
  take_trip();
  take_shape();
}

void PhysicsRecorder::take_haptic_ticks() {
  drain(ticks_.haptic, haptic_next_, missed_, [this](const RecordedHapticTick& tick) {
    write(sample_, tick.tick.begun, encode_sample(tick));
    write(force_, tick.tick.begun, encode_force(tick.tick));
    if (recording_.log_time(tick.tick.begun.ns()) >= next_show_) show(tick);
  });
}

void PhysicsRecorder::take_steps() {
  drain(ticks_.steps, step_next_, missed_, [this](const RecordedStep& step) {
    write(step_, step.now, encode_step(step));
    last_step_ = step.now;
    if (!step.state) return;
    write(state_, step.now, transport::encode(*step.state));
    if (const auto time = recording_.log_time(step.now.ns()); time >= next_bodies_)
      show_bodies(*step.state, time);
  });
}

void PhysicsRecorder::take_trip() {
  const haptics::HapticCondition condition = loop_.condition();
  if (condition.trips == trips_seen_) return;
  trips_seen_ = condition.trips;
  recording::Trip out;
  out.set_tick(condition.trip_tick);
  out.set_state(static_cast<wire::ForceState>(transport::wire_number(condition.state)));
  out.set_fault(static_cast<wire::ForceFault>(transport::wire_number(condition.trip_fault)));
  out.set_culprit(static_cast<recording::Guest>(static_cast<int>(condition.trip_culprit)));
  const std::uint64_t end = ticks_.haptic.count();
  const auto last = end > 0 ? ticks_.haptic.read(end - 1) : std::nullopt;
  if (last) write(trip_, last->tick.begun, out.SerializeAsString());
}

// The newest: the surface is pushed less often than the world steps.
void PhysicsRecorder::take_shape() {
  if (shapes_ == nullptr || last_step_ < next_shape_) return;
  const auto time = shape_source_(last_step_, shape_.values);
  if (!time || *time <= shape_.time) return;
  shape_.time = *time;
  next_shape_ = std::max(next_shape_ + kShapeEvery, *time);
  write(*shapes_, *time, shape_encoder_.encode(shape_));
}

void PhysicsRecorder::write(const LoopFigures& loop, Instant<PhysicsClock> now) {
  recording::Loop out;
  out.set_name(loop.name);
  out.set_rate_hz(loop.rate_hz);
  out.set_ticks(loop.ticks);
  out.set_overruns(loop.overruns);
  out.set_missed(loop.missed);
  out.set_late_p50_us(loop.late_p50_us);
  out.set_late_p99_us(loop.late_p99_us);
  out.set_late_max_us(loop.late_max_us);
  write(loops_, now, out.SerializeAsString());
}

void PhysicsRecorder::show(const RecordedHapticTick& recorded) {
  const haptics::HapticTick& tick = recorded.tick;
  const std::uint64_t time = recording_.log_time(tick.begun.ns());
  next_show_ = std::max(next_show_ + kShowEvery, time);
  foxglove::FrameTransforms frames;
  add_frame(frames, time, "World", "ArmBase", X_world_base_.translation, X_world_base_.rotation);
  add_frame(frames, time, "World", "Tip", tick.tip, Quaternion::Identity());
  write(tf_, tick.begun, frames.SerializeAsString());

  recording::Plot plot;
  const Vector3 requested = tick.continuous + tick.impact;
  put(plot.mutable_tip_m(), tick.tip);
  plot.set_tip_speed_m_s(tick.speed);
  plot.set_requested_n(requested.norm());
  plot.set_commanded_n(tick.commanded.norm());
  put(plot.mutable_force_n(), requested);
  write(plot_, tick.begun, plot.SerializeAsString());
  if (time >= next_scene_) show_scene(time);
}

void PhysicsRecorder::show_scene(std::uint64_t log_time) {
  next_scene_ = log_time + kSceneEvery;
  shown_scene_.write(log_time, log_time, encode_scene(scene_, log_time));
}

void PhysicsRecorder::show_bodies(const scene::SceneState& state, std::uint64_t log_time) {
  next_bodies_ = std::max(next_bodies_ + kShowEvery, log_time);
  if (const auto bodies = encode_bodies(scene_, state, log_time); !bodies.empty())
    tf_.write(log_time, log_time, bodies);
}

}  // namespace palpate::record::session
