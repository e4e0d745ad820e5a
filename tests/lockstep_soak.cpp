// Ping-pong in lock-step without pictures for as long as one likes, on a rig whose calibrations are the
// truth: what tests/soak.py watches from outside. A line of CSV for every few seconds of virtual time.
#include <fmt/format.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <vector>

#include "applications/pingpong/pingpong.h"
#include "applications/pingpong/specification.h"
#include "palpate/core/statistics.h"
#include "palpate/server/physics/physics_server.h"
#include "palpate/sim/config/world_scene.h"
#include "palpate/sim/lockstep/lockstep_play.h"
#include "palpate/sim/truth_rig.h"

namespace palpate {
namespace {

// What one line tells of.
struct Stretch {
  double begun_s = 0.0, worst_error_s = 0.0;
  std::vector<double> uncertainties_s, round_trips_s;
};

int soak(double play_seconds, double every_s) {
  constexpr std::uint64_t kSeed = 1;
  sim::Simulator world(sim::config::reference_world(), kSeed);
  const rig::Rig rig = sim::truth_rig(world);
  const auto scene = server::physics::scene_from_rig(
      rig, *sim::config::scene_of(world.file(), {applications::pingpong::specification()}, "pingpong"));
  sim::lockstep::LockstepOptions options;
  options.applications = {applications::pingpong::specification()};
  options.seconds = play_seconds;
  options.seed = kSeed;
  Stretch stretch;
  const Instant<TrueTime> start = world.now() + seconds(options.warm_up_s);
  options.pass_on = [&](const sim::lockstep::LockstepFrame& frame) {
    const double t = to_seconds(world.now() - start);
    stretch.worst_error_s = std::max(stretch.worst_error_s, std::abs(frame.sync_error_s));
    stretch.uncertainties_s.push_back(frame.sync_uncertainty_s);
    for (const double trip : frame.round_trips_s) stretch.round_trips_s.push_back(trip);
    if (t < stretch.begun_s + every_s) return;
    const auto& counters = frame.played.record.state.counters;
    fmt::print("{:.3f},{:.3f},{:.3f},{:.3f},{},{}\n", t, 1e6 * stretch.worst_error_s,
               1e6 * median(stretch.uncertainties_s), 1e6 * median(stretch.round_trips_s),
               counters[applications::pingpong::kServes], counters[applications::pingpong::kReturned]);
    std::fflush(stdout);
    stretch.begun_s += every_s;
    stretch.worst_error_s = 0.0;
    stretch.uncertainties_s.clear();
    stretch.round_trips_s.clear();
  };
  fmt::print("time_s,clock_error_us,clock_uncertainty_us,round_trip_us,serves,returned\n");
  const auto result = sim::lockstep::play_in_lockstep(world, rig, scene, options, {}, {});
  if (!result) {
    fmt::print(stderr, "lockstep_soak: {}\n", result.error().message);
    return 1;
  }
  return 0;
}

}  // namespace
}  // namespace palpate

int main(int count, char** arguments) {
  const double play_seconds = count == 3 ? std::atof(arguments[1]) : 0.0;
  const double every_s = count == 3 ? std::atof(arguments[2]) : 0.0;
  if (!(play_seconds > 0.0) || !(every_s > 0.0)) {
    fmt::print(stderr, "usage: palpate_lockstep_soak SECONDS SECONDS-BETWEEN-LINES\n");
    return 2;
  }
  return palpate::soak(play_seconds, every_s);
}
