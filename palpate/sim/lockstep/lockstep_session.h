// A session in the simulated laboratory, on the virtual clock, from values to figures: what `palpate lockstep` runs, and Python
// through it. Plain values go in, JSON comes out; nothing is drawn.
//
// The same request gives the same figures and the same recorded messages to the last bit. One thread. Errors: wrong use for an
// application that is not known and for settings out of range; refused where nobody plays the application, and as
// play_in_lockstep().
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "palpate/core/expected.h"
#include "palpate/core/json.h"
#include "palpate/rig/rig.h"
#include "palpate/scene/application_registry.h"
#include "palpate/sim/config/world_file.h"
#include "palpate/transport/in_process.h"

namespace palpate::sim::lockstep {

struct SessionRequest {
  scene::ApplicationRegistry applications;
  std::string application;
  config::WorldFile world;  // with the applications' settings, and the delays that [display] adds on purpose
  std::optional<rig::Rig> rig;  // none: one whose calibrations are the truth
  std::uint64_t seed = 1;       // draws the laboratory, all noise, the channel's delays and the player
  double seconds = 10.0;
  transport::ChannelModel channel;
  double player_extra_delay_s = 0.0;  // the player sees everything so much later
  std::filesystem::path record;       // as of LockstepOptions
  std::function<void(double)> progress;
};

struct SessionOutcome {
  // application, seed, seconds, rig ("truth" or "given"), settings {NAME: VALUE, in the unit that the name says}, registration
  // (overlay_figures), exchange, force, player (play_figures.h), what the application's record adds, and events (PlayEvents).
  Json figures;
  // For a person: the application's, and a warning where the rig is another laboratory's.
  std::vector<scene::ClosingLine> lines;
};

Expected<SessionOutcome> run_session(const SessionRequest& request);

}  // namespace palpate::sim::lockstep
