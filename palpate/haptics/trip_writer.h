// Writes the last seconds of a haptic loop to a file whenever something trips, in a thread of its own: the
// haptic thread never waits for a disk.
//
// A trip's file, trip_N.csv, holds the ticks up to half a second after it, oldest first; whole or not at all. Not more
// than kMostFiles in a run and one in kLeastApart, so that a fault that comes and goes fills no disk; what is
// left out is counted. Every trip, with a file or without, is a row of realtime_trips.csv (trip_log.h), which is there once there was
// one. The loop must outlive this object.
#pragma once

#include <atomic>
#include <cstdint>
#include <filesystem>
#include <string>
#include <thread>

#include "palpate/core/expected.h"
#include "palpate/haptics/haptic_loop.h"
#include "palpate/haptics/trip_log.h"

namespace palpate::haptics {

// The table, with a first line that says what tripped.
std::string trip_csv(const HapticCondition& trip, const std::vector<HapticRecord>& records);

class TripWriter {
 public:
  static constexpr int kMostFiles = 4;
  static constexpr Duration kLeastApart = std::chrono::seconds(10);

  // A fault that does not heal by itself is a line of the physics server's log, from this object's thread.
  // `begun`: what the rows' times count from.
  TripWriter(const HapticLoop& loop, std::filesystem::path folder, Instant<PhysicsClock> begun = {});
  ~TripWriter() { stop(); }
  TripWriter(const TripWriter&) = delete;
  TripWriter& operator=(const TripWriter&) = delete;

  // Writes what is still to be written and ends the thread. Once; then the counts are final.
  void stop();
  // After stop(): every one.
  const TripLog& log() const { return log_; }
  std::uint64_t written() const { return written_.load(); }
  std::uint64_t left_out() const { return left_out_.load(); }

 private:
  void watch();
  void look(bool at_the_end);
  void write(const HapticCondition& trip, std::uint64_t until);
  void write_log(bool at_the_end);

  const HapticLoop& loop_;
  std::filesystem::path folder_;
  Instant<PhysicsClock> begun_;
  TripLog log_;
  bool log_is_newer_ = false;  // than its file
  std::chrono::steady_clock::time_point log_written_;
  HapticCondition pending_;  // where `open_`
  bool open_ = false;
  std::uint64_t seen_ = 0;
  std::chrono::steady_clock::time_point noticed_, last_written_;
  std::atomic<std::uint64_t> written_{0}, left_out_{0};
  std::atomic<bool> stopping_{false};
  std::thread thread_;
};

}  // namespace palpate::haptics
