#include "palpate/sim/lockstep/internal/play_recording.h"

namespace palpate::sim::lockstep {

Expected<std::unique_ptr<PlayRecording>> PlayRecording::begin(const std::filesystem::path& file,
                                                              server::physics::PhysicsSide& side,
                                                              const rig::Rig& rig) {
  auto begun = record::session::SessionRecording::begin(
      file, {.recorder = "lock-step", .on_error = [](const Error&) {}, .wall_time = false});
  if (!begun) return tl::unexpected(begun.error());
  std::unique_ptr<PlayRecording> play(new PlayRecording);
  play->recording_ = std::move(*begun);
  play->ticks_ = std::make_unique<record::session::PhysicsTicks>();
  play->recorder_ = std::make_unique<record::session::PhysicsRecorder>(
      *play->recording_, *play->ticks_, side.server().haptic(), rig, side.scene());
  play->recorder_->record_shapes([&server = side.server()](Instant<PhysicsClock> t, std::span<float> out) {
    return server.shape_at(t, out);
  });
  side.server().record_to(*play->ticks_);
  return play;
}

Expected<void> PlayRecording::end() {
  recorder_->stop();
  auto figures = recording_->finish();
  if (!figures) return tl::unexpected(figures.error());
  if (recorder_->missed() == 0 && figures->at("dropped").empty()) return {};
  return refused("{}: the disk is too slow for the virtual clock, and messages were lost; name a faster one",
                 recording_->file().string());
}

}  // namespace palpate::sim::lockstep
