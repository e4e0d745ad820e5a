// The simulated laboratory as a process of its own, in real time: its devices for the two servers over shared memory.
//
// A world thread moves the truth on every millisecond, hands out samples and takes forces and hand targets; a second
// thread draws what the camera saw and hands each picture out when the camera's latency has passed. True time is the
// machine's monotonic time since the start.
#pragma once

#include <cstdint>
#include <string>

#include "palpate/core/expected.h"
#include "palpate/sim/world_file.h"
#include "palpate/time/periodic_loop.h"

namespace palpate {

struct WorldProcessOptions {
  sim::WorldFile world;
  std::uint64_t seed = 1;
  std::string lab = "lab";
  double seconds = 0.0;  // 0 = until asked to stop
  bool real_time = true;
};

struct WorldProcessResult {
  LoopStatistics loop;
  std::uint64_t images = 0;       // handed out
  std::uint64_t late_images = 0;  // drawn later than the camera's latency allows
};

Expected<WorldProcessResult> run_world_process(const WorldProcessOptions& options);

}  // namespace palpate
