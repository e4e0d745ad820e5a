// The recording of a play in lock-step: what the physics side did, tick by tick, from the first tick that counts. The same
// topics as of a session in real time; log times are those of the virtual clock.
//
// One thread, which ticks; the physics side must outlive it.
#pragma once

#include <filesystem>
#include <memory>

#include "palpate/record/session/physics_recorder.h"
#include "palpate/server/physics/physics_side.h"

namespace palpate::sim::lockstep {

class PlayRecording {
 public:
  // A new file. Errors: as SessionRecording::begin().
  static Expected<std::unique_ptr<PlayRecording>> begin(const std::filesystem::path& file,
                                                        server::physics::PhysicsSide& side,
                                                        const rig::Rig& rig);
  // Takes what has been done since; every few milliseconds, so that the surface that deforms is taken as often as it shows.
  void look() { recorder_->look(); }
  // The rest is written. Refused where the disk has refused or was too slow: a recording of a virtual clock is whole.
  Expected<void> end();

 private:
  PlayRecording() = default;

  std::unique_ptr<record::session::PhysicsTicks> ticks_;
  std::unique_ptr<record::session::SessionRecording> recording_;
  std::unique_ptr<record::session::PhysicsRecorder> recorder_;  // gone first: it writes into the recording
};

}  // namespace palpate::sim::lockstep
