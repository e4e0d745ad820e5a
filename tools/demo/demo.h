// The main job: calibrate a simulated laboratory through its devices, play in lock-step, then in real time as
// three processes, and leave a folder that a person can read and a script can check.
//
// With a window the real-time run comes right after the calibration and a person may play it with the mouse,
// for as long as they like; the scripted player holds the stylus until they do. Where nobody does, the run ends
// as it does without a window.
//
// Writes summary.json, report.html, rig.toml, video.mp4, pictures/ and raw/ into the folder. Everything
// outside summary.json's "realtime" and "made" is the same to the bit for the same world, seed and options.
#pragma once

#include <cstdint>
#include <filesystem>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "palpate/core/build_info.h"
#include "palpate/core/expected.h"
#include "palpate/core/json.h"
#include "palpate/desktop/spectator_window.h"
#include "palpate/render/compositor.h"
#include "palpate/scene/application_registry.h"
#include "palpate/sim/config/world_file.h"
#include "tools/demo/test_network.h"

namespace palpate::tools::demo {

struct DemoOptions {
  scene::ApplicationRegistry applications;  // of the program
  std::string application;                  // one of them
  double seconds = 30.0;
  double realtime_s = 10.0;
  double most_pictures = std::numeric_limits<double>::infinity();  // in lock-step: further apart, if need be
  std::uint64_t seed = 1;
  sim::config::WorldFile world;
  std::filesystem::path world_path;  // for the real-time processes; empty = the reference world
  std::filesystem::path out = "palpate-report";
  std::filesystem::path program;  // this executable, for the real-time run; empty leaves that run out
  std::string command;            // as typed, for the report
  BuildInfo build;                // of this program, for the report
  bool quick = false;
  std::optional<render::Quality> quality;  // of the pictures; none: by what is missed, in lock-step medium
  std::optional<desktop::MonitorView> monitor;  // beside the window, for those who look on
  bool headset = false;                         // the real-time run's pictures in a headset as well
  bool window = false;  // on this machine's display: the real-time run comes first, and a person may play it
  std::optional<TwoHostsOptions> two_hosts;  // for the real-time run
  std::filesystem::path record;              // a new file for a recording of that run; empty: none
  std::string recorded_pictures;             // in it: jpeg, lossless; empty: none
};

struct DemoResult {
  Json summary;                       // as it was written
  std::vector<std::string> in_words;  // the lines it ends with
};
Expected<DemoResult> run_demo(const DemoOptions& options);

}  // namespace palpate::tools::demo
