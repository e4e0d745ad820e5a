// Every trip of a haptic loop: when, why, how long forces were away and what the hand did not get meanwhile.
//
// The loop's rings tell; nobody waits. One thread, not the haptic one, looks often enough: what the rings have overwritten (8 s at
// 1 kHz) counts as nothing lost. World frame and SI; the physics clock.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "palpate/haptics/haptic_loop.h"

namespace palpate::haptics {

struct LoggedTrip {
  HapticTrip trip;
  double away_s = 0.0;    // from the trip until its reason had gone, or until now, or until the next trip
  double lost_n_s = 0.0;  // what was asked for beyond what was given in that time
  bool returned = false;  // forces may be given again
  std::string file;       // of the seconds before it, where there is one
};

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
