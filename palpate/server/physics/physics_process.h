// The physics server as a process: haptic loop and physics loop in threads of their own, states served over
// ZeroMQ. What a person should know while it runs is in the log, of the part "physics".
#pragma once

#include <filesystem>
#include <functional>
#include <string>

#include "palpate/core/expected.h"
#include "palpate/core/json.h"
#include "palpate/server/physics/physics_side.h"

namespace palpate::server::physics {

struct PhysicsProcessOptions : PhysicsSetup {
  std::string endpoint;  // empty = this user's default socket
  bool insecure = false;
  std::filesystem::path keys;  // folder; empty = this user's
  double seconds = 0.0;        // 0 = until asked to stop
  bool real_time = true;
  std::filesystem::path
      out;  // realtime_loops.csv, realtime_jitter.csv, trip_*.csv; empty = trips only, in the run folder
  // The rig's file as it was read, for the recording: what is read from it again is the same to the last bit, which another text
  // of the same rig need not be. Empty: there was none.
  std::string rig_text;
  std::filesystem::path record;  // a new file for a recording of the session; empty: none
  std::function<void()> ready;   // called once, when graphics servers are answered
};

// Rates, overruns, jitter, forces and exchange counts of the whole run; also written by `palpate physics
// --json`.
Expected<Json> run_physics_process(const PhysicsProcessOptions& options);

}  // namespace palpate::server::physics
