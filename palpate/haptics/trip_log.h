// Each time a fault took forces from the hand: when, why, for how long, and what the hand did not get meanwhile.
//
// An outage of at most 50 ms heals as if it had not been (device::ForceStrength). A trip is a longer one, or one that a
// person has to re-arm.
//
// The loop's rings tell; nobody waits. One thread, not the haptic one, looks often enough: what the rings have overwritten (8 s at
// 1 kHz) counts as nothing lost. World frame and SI; the physics clock.
#pragma once

#include <algorithm>
#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "palpate/haptics/haptic_loop.h"

namespace palpate::haptics {

struct LoggedTrip {
  HapticTrip trip;
  double away_s = 0.0;    // from the trip until its reason had gone, or until now, or until the next trip
  double lost_n_s = 0.0;  // what was asked for beyond what was given in that time
  double outage_s =
      0.0;  // by real time, from the last that was good (device::ForceStrength); 0: not over yet
  bool returned = false;  // forces may be given again
  std::string file;       // of the seconds before it, where there is one

  bool is_trip() const {
    return !heals(trip.fault) ||
           std::max(outage_s, away_s) > device::ForceStrength::Settings{}.brief_s + 1e-9;
  }
};

// What a run's figures say of them.
struct TripSummary {
  std::uint64_t outages = 0, trips = 0;
  double longest_outage_s = 0.0;  // of those that healed
  std::map<std::string, std::uint64_t> trip_causes, outage_causes;
};
TripSummary summary_of(const std::vector<LoggedTrip>& trips);

class TripLog {
 public:
  // What lies beyond `most` is counted only: a fault that comes and goes fills no disk.
  explicit TripLog(const HapticLoop& loop, std::size_t most = 10'000) : loop_(loop), most_(most) {}

  // Takes what has come since the last call. True where a trip has begun or ended.
  bool look();
  void set_file(std::uint64_t trip_tick, std::string name);

  const std::vector<LoggedTrip>& trips() const { return trips_; }
  std::uint64_t left_out() const { return left_out_; }

 private:
  void follow(const HapticRecord& record);

  const HapticLoop& loop_;
  std::size_t most_;
  std::vector<LoggedTrip> trips_;
  std::uint64_t left_out_ = 0, seen_ = 0, scanned_ = 0;  // trips and ticks
  bool open_ = false;                                    // forces are away since the newest
  Instant<PhysicsClock> before_;
};

// A row for each; times since `begun`, causes in words.
std::string trips_csv(const std::vector<LoggedTrip>& trips, Instant<PhysicsClock> begun,
                      const HapticLoop& loop);

}  // namespace palpate::haptics
