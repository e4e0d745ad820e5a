// The demo's real-time leg: laboratory, physics server and graphics server as three processes on the
// machine's clock.
#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <string>

#include "palpate/compositor/compositor.h"
#include "palpate/core/expected.h"
#include "palpate/core/json.h"
#include "palpate/model/world_file.h"
#include "palpate/system/leg_network.h"
#include "palpate/system/monitor_seat.h"
#include "palpate/time/instant.h"

namespace palpate {

struct RealtimeLegOptions {
  std::filesystem::path program;  // this executable
  std::filesystem::path rig;      // file
  std::string application = "pingpong";
  std::filesystem::path world;  // file
  std::filesystem::path out;    // folder for its raw files
  std::uint64_t seed = 1;
  Quality quality = Quality::medium;  // of the pictures
  double seconds = 10.0;
  // Physics and graphics on hosts of their own, and the cable between them pulled in the middle of the leg.
  std::optional<TwoHostsOptions> two_hosts;
  // The graphics server opens a window in which a person may take the bat with the mouse, and play on beyond
  // `seconds`.
  bool window = false;
  std::optional<MonitorView> monitor;  // beside it, for those who look on
  Duration scan_out{0};                // the simulated display's, as the world file has it
  sim::ClockSettings graphics_clock;   // what the graphics process disguises its clock with
};

// The summary's "realtime" part. Refused where a process fails; what it said last is in the message.
Expected<Json> run_realtime_leg(const RealtimeLegOptions& options,
                                const std::function<void(double)>& progress);

}  // namespace palpate
