// The demo's real-time run: laboratory, physics server and graphics server as three processes on the
// machine's clock.
#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <string>

#include "palpate/core/expected.h"
#include "palpate/core/json.h"
#include "palpate/desktop/spectator_window.h"
#include "palpate/render/compositor.h"
#include "palpate/scene/application_registry.h"
#include "palpate/sim/config/world_file.h"
#include "palpate/time/instant.h"
#include "tools/demo/joint_recording.h"
#include "tools/demo/test_network.h"

namespace palpate::tools::demo {

struct RealtimeRunOptions {
  std::filesystem::path program;  // this executable
  std::filesystem::path rig;      // file
  std::string application;
  scene::ApplicationRegistry applications;
  std::filesystem::path world;  // file
  std::filesystem::path out;    // folder for its raw files
  std::uint64_t seed = 1;
  std::optional<render::Quality> quality;  // of the pictures; none: by what is missed
  double seconds = 10.0;
  // Physics and graphics on hosts of their own, and the cable between them pulled in the middle of the run.
  std::optional<TwoHostsOptions> two_hosts;
  // The graphics server opens a window in which a person may take the stylus with the mouse, and play on beyond
  // `seconds`.
  bool window = false;
  std::optional<desktop::MonitorView> monitor;  // beside it, for those who look on
  bool headset = false;                         // its pictures in a headset as well
  JointRecording recording;                     // of both servers
  std::string recorded_pictures;                // in it: jpeg, lossless; empty: none
  Duration scan_out{0};                         // the simulated display's, as the world file has it
  sim::config::ClockSettings graphics_clock;    // what the graphics process disguises its clock with
};

// The summary's "realtime" part. Refused where a process fails; what it said last is in the message.
Expected<Json> run_realtime(const RealtimeRunOptions& options, const std::function<void(double)>& progress);

}  // namespace palpate::tools::demo
