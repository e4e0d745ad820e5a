#include "palpate/haptics/trip_log.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "palpate/core/csv.h"

namespace palpate::haptics {

bool TripLog::look() {
  const std::uint64_t begun = loop_.trip_count(), ticks = loop_.record_count();
  const bool fresh = begun != seen_;
  if (!fresh && !open_) {
    scanned_ = ticks;
    return false;
  }
  std::vector<HapticTrip> coming;
  for (; seen_ != begun; ++seen_) {
    if (const auto trip = loop_.trip(seen_))
      coming.push_back(*trip);
    else
      ++left_out_;  // overwritten
  }
  // Trip and record of a tick are not told at one moment.
  if (!coming.empty()) scanned_ = std::min(scanned_, coming.front().tick - 1);
  const bool was_open = open_;
  auto next = coming.begin();
  for (; scanned_ < ticks; ++scanned_) {
    const auto record = loop_.record(scanned_);
    if (next != coming.end() && next->tick <= scanned_ + 1) {
      open_ = trips_.size() < most_;
      if (open_)
        trips_.push_back({.trip = *next, .file = {}});
      else
        ++left_out_;
      before_ = next->time;
      ++next;
    }
    if (record && open_) follow(*record);
  }
  return fresh || was_open != open_;
}

void TripLog::follow(const HapticRecord& record) {
  auto& newest = trips_.back();
  newest.away_s = to_seconds(record.time - newest.trip.time);
  if (std::isfinite(record.outage_s)) newest.outage_s = std::max(0.0, record.outage_s);
  if (record.fault == ForceFault::none && record.state != ForceState::safe) {
    newest.returned = true;
    open_ = false;
    return;
  }
  const double withheld = std::max(0.0, record.requested.norm() - record.commanded.norm());
  newest.lost_n_s += withheld * std::max(0.0, to_seconds(record.time - before_));
  before_ = record.time;
}

void TripLog::set_file(std::uint64_t trip_tick, std::string name) {
  const auto of = std::find_if(trips_.rbegin(), trips_.rend(),
                               [&](const LoggedTrip& trip) { return trip.trip.tick == trip_tick; });
  if (of != trips_.rend()) of->file = std::move(name);
}

TripSummary summary_of(const std::vector<LoggedTrip>& trips) {
  TripSummary summary;
  for (const LoggedTrip& logged : trips) {
    const std::string cause(name_of(logged.trip.fault));
    if (logged.is_trip()) {
      ++summary.trips;
      ++summary.trip_causes[cause];
    } else {
      ++summary.outages;
      ++summary.outage_causes[cause];
    }
    if (heals(logged.trip.fault))
      summary.longest_outage_s = std::max({summary.longest_outage_s, logged.outage_s, logged.away_s});
  }
  return summary;
}

std::string trips_csv(const std::vector<LoggedTrip>& trips, Instant<PhysicsClock> begun,
                      const HapticLoop& loop) {
  CsvWriter csv(
      {"time_s", "tick", "cause", "who", "away_s", "returned", "lost_n_s", "file", "outage_s", "kind"});
  for (const LoggedTrip& logged : trips) {
    const auto& [trip, away_s, lost_n_s, outage_s, returned, file] = logged;
    csv.row({fmt::format("{:.4f}", to_seconds(trip.time - begun)), fmt::format("{}", trip.tick),
             std::string(name_of(trip.fault)), loop.name_of(trip.culprit), fmt::format("{:.4f}", away_s),
             returned ? "1" : "0", number_text(lost_n_s), file, fmt::format("{:.4f}", outage_s),
             logged.is_trip() ? "trip" : "outage"});
  }
  return csv.content();
}

}  // namespace palpate::haptics
