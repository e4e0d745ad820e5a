// The physics server as a process: haptic loop and physics loop in threads of their own, states served over
// ZeroMQ.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>

#include "palpate/core/expected.h"
#include "palpate/core/json.h"
#include "palpate/device/driver_registry.h"
#include "palpate/rig/rig.h"
#include "palpate/scene/application_registry.h"

namespace palpate::server::physics {

struct PhysicsProcessOptions {
  rig::Rig rig;
  scene::ApplicationRegistry applications;
  scene::SceneDescription scene;  // without surfaces: those are the rig's
  double surface_restitution = 0.93;
  device::DriverRegistry drivers;
  device::ArmRequest arm{.uri = "lab", .nominal = {}};  // its model is taken from the rig
  std::string endpoint;                                 // empty = this user's default socket
  bool insecure = false;
  std::filesystem::path keys;  // folder; empty = this user's
  scene::RunSettings run;
  double seconds = 0.0;  // 0 = until asked to stop
  double physics_hz = 1000.0, haptic_hz = 1000.0;
  bool real_time = true;
  Duration extra_force_delay{0};  // forces come so much later, on purpose
  std::filesystem::path
      out;  // realtime_loops.csv, realtime_jitter.csv, trip_*.csv; empty = trips only, in the run folder
  std::function<void(const std::string&)> notice;  // what a person should know while it runs, a line each
  std::function<void()> ready;                     // called once, when graphics servers are answered
};

// Rates, overruns, jitter, forces and exchange counts of the whole run; also written by `palpate physics
// --json`.
Expected<Json> run_physics_process(const PhysicsProcessOptions& options);

}  // namespace palpate::server::physics
