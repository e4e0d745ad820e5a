// `palpate world run`: the simulated laboratory as a process in real time, whose devices others use over
// LabServer.
//
// The world's time is the machine's monotonic clock since the start. One thread moves the world and serves
// arm, tracker and hand once a millisecond; another draws the camera's pictures, so that drawing never holds
// up the arm, and paints the display that hangs in their view (simulated_display.h). Faults of the world file
// (device_faults.h) count from the start, and are told as they begin and end. A world that cannot keep up
// falls behind in what it shows, never in its stamps; how far is counted. The log's part is "world".
#pragma once

#include <atomic>
#include <filesystem>
#include <functional>
#include <string>

#include "palpate/core/expected.h"
#include "palpate/sim/simulator.h"

namespace palpate::sim {

struct WorldProcessOptions {
  std::string name = "lab";
  std::filesystem::path folder;  // of the channel's file; empty: the user's run directory
  std::uint64_t seed = 1;
  double seconds = 0.0;  // 0: until stopped
  // Where to write when each image was taken and what was true then (exposure_log.h), for whoever judges
  // delays and overlay afterwards; empty: nowhere.
  std::filesystem::path exposures;
  std::filesystem::path trace;  // of the camera's drawing (core/trace_log.h), written at the end; empty: none
  // Makes the renderer, in the thread that will use it; none: no pictures.
  std::function<RenderView()> make_renderer;
  std::function<void()> ready;  // called once, when the devices are open
  // The laboratory's person does what lines on standard input say (gesture_lines.h), and nobody plays until somebody
  // leads the hand.
  bool gestures = false;
};

struct WorldProcessReport {
  std::uint64_t ticks = 0, late_ticks = 0;  // late: served more than a millisecond after its time
  double worst_late_s = 0.0;
  std::uint64_t images = 0;
  std::string picture_fault;  // why pictures ended early; arm, tracker and hand go on without them
};

// Serves until `stop` is set or the time is over.
Expected<WorldProcessReport> run_world(const config::WorldFile& file, const WorldProcessOptions& options,
                                       const std::atomic<bool>& stop);

}  // namespace palpate::sim
