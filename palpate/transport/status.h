// How a running system is doing, as the physics server tells it: its loops, its clients, and what each client
// counts for itself.
//
// Values; times in the units of their names.
#pragma once

#include <fmt/format.h>

#include <algorithm>
#include <cstdint>
#include <functional>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "palpate/device/force_condition.h"
#include "palpate/device/health.h"
#include "palpate/time/periodic_loop.h"
#include "palpate/transport/keys.h"

namespace palpate::transport {

// What is wrong with a device of a client, as of its word of it.
struct ClientCondition {
  device::HealthCode code = device::HealthCode::camera_silent;
  double age_s = 0.0;  // since it began
  std::string words;   // at most 180 bytes travel
};

// Of one graphics server, since it began.
struct ClientFigures {
  std::uint64_t frames = 0, late = 0, lost = 0;  // late: drawn with the state before
  double rate_hz = 0.0;
  double round_trip_median_us = 0.0, round_trip_p99_us = 0.0;
  double clock_offset_s = 0.0;        // server's clock minus the client's
  double clock_uncertainty_us = 0.0;  // as the client states it
  // What is wrong with its devices: of each client the first four travel.
  std::vector<ClientCondition> conditions{};
};

// Whether the same is wrong with both, however long by now.
inline bool same_trouble(const ClientFigures& a, const ClientFigures& b) {
  const auto same = [](const ClientCondition& x, const ClientCondition& y) {
    return x.code == y.code && x.words == y.words;
  };
  return std::equal(a.conditions.begin(), a.conditions.end(), b.conditions.begin(), b.conditions.end(), same);
}

struct LoopStatus {
  std::string name;
  double rate_hz = 0.0;  // as it runs
  std::uint64_t ticks = 0, overruns = 0, missed = 0;
  double late_p50_us = 0.0, late_p99_us = 0.0, late_max_us = 0.0, busy_p99_us = 0.0;
  std::vector<std::uint64_t> late_octaves;       // ticks less than 16 ns late, 32 ns, 64 ns, ...
  std::optional<device::ForceCondition> forces;  // where the loop gives any
  std::string culprit;                           // the application that has brought it about; empty: none
  double peak_n = 0.0, continuous_n = 0.0;  // what is given at most, and as root mean square; 0: not said
  std::uint64_t trips = 0;                  // outages of the forces so far

  // For people: "running", "safe: overspeed"; empty where the loop gives no forces.
  std::string forces_text() const {
    if (!forces) return {};
    return device::condition_text(*forces) + (culprit.empty() ? "" : fmt::format(" ({})", culprit));
  }
};

struct ClientStatus {
  std::string name;
  Role role = Role::observer;
  ClientFigures figures;
};

// The physics server's own.
struct RecordingStatus {
  double seconds = 0.0;
  std::uint64_t dropped = 0;  // messages so far
  bool ended = false;         // by an error of the disk
};

struct ServerStatus {
  double uptime_s = 0.0;
  std::string application;
  std::string failure{};  // what it threw, and what has become of it; empty: nothing
  std::vector<LoopStatus> loops;
  std::vector<ClientStatus> clients;  // heard within the last second
  std::uint64_t requests = 0, syncs = 0, controls = 0, rejected = 0, rejected_connections = 0, unsent = 0,
                published = 0;
  std::optional<RecordingStatus> recording{};
};

// Gives uptime and loops; the service adds the rest. Called on the network thread, must not wait.
using StatusSource = std::function<ServerStatus()>;

// What the one thread that looks after the loops writes, and the network's reads. Not for the loops
// themselves.
class StatusBoard {
 public:
  void write(ServerStatus status) {
    const std::lock_guard lock(mutex_);
    status_ = std::move(status);
  }
  ServerStatus read() const {
    const std::lock_guard lock(mutex_);
    return status_;
  }

 private:
  mutable std::mutex mutex_;
  ServerStatus status_;
};

template <typename C>
LoopStatus loop_status(std::string name, const PeriodicLoop<C>& loop) {
  const auto us = [](Duration d) { return static_cast<double>(d.count()) * 1e-3; };
  const LoopStatistics s = loop.statistics();
  const auto octaves = loop.lateness().octaves();
  return {.name = std::move(name),
          .rate_hz = s.rate_hz,
          .ticks = s.ticks,
          .overruns = s.overruns,
          .missed = s.missed,
          .late_p50_us = us(s.late_p50),
          .late_p99_us = us(s.late_p99),
          .late_max_us = us(s.late_max),
          .busy_p99_us = us(s.busy_p99),
          .late_octaves = {octaves.begin(), octaves.end()},
          .forces = {},
          .culprit = {}};
}

}  // namespace palpate::transport
