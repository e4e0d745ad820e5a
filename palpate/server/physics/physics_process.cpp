#include "palpate/server/physics/physics_process.h"

#include <fmt/format.h>

#include <atomic>
#include <cstdio>
#include <cstdlib>
#include <memory>
#include <optional>
#include <thread>
#include <utility>

#include "palpate/core/csv.h"
#include "palpate/core/csv_file.h"
#include "palpate/core/file.h"
#include "palpate/core/log.h"
#include "palpate/core/run_directory.h"
#include "palpate/core/stop_signal.h"
#include "palpate/device/health_monitor.h"
#include "palpate/haptics/trip_writer.h"
#include "palpate/record/session/physics_recorder.h"
#include "palpate/server/physics/guest_news.h"
#include "palpate/server/physics/physics_loops.h"
#include "palpate/server/physics/recorded_setup.h"
#include "palpate/server/physics/serving_place.h"

namespace palpate::server::physics {
namespace {

constexpr Log kLog("physics");

Json loop_json(const LoopStatistics& loop) {
  const auto us = [](Duration d) { return static_cast<double>(d.count()) * 1e-3; };
  return {{"rate_hz", loop.rate_hz},
          {"ticks", loop.ticks},
          {"overruns", loop.overruns},
          {"missed", loop.missed},
          {"missed_in_a_row", loop.missed_in_a_row},
          {"jitter_us",
           {{"p50", us(loop.late_p50)},
            {"p99", us(loop.late_p99)},
            {"p99.9", us(loop.late_p999)},
            {"max", us(loop.late_max)}}},
          {"busy_us", {{"p50", us(loop.busy_p50)}, {"p99", us(loop.busy_p99)}, {"max", us(loop.busy_max)}}}};
}

// Clients and loops as they stand at a moment; counts since the start. Written as it goes: a server may run
// for days.
struct LoopsLog {
  CsvFile rows;

  static Expected<std::optional<LoopsLog>> begin(const std::filesystem::path& folder) {
    if (folder.empty()) return std::nullopt;
    auto rows = CsvFile::begin(folder / "realtime_loops.csv",
                               {"time_s", "clients", "requests", "haptic_ticks", "haptic_overruns",
                                "haptic_missed", "physics_ticks", "physics_overruns", "physics_missed"});
    if (!rows) return tl::unexpected(rows.error());
    return LoopsLog{std::move(*rows)};
  }

  void look(double time_s, const transport::ServiceCounters& service, const LoopStatistics& haptic,
            const LoopStatistics& physics) {
    std::vector<double> row{time_s, static_cast<double>(service.clients),
                            static_cast<double>(service.requests)};
    for (const auto& loop : {haptic, physics})
      for (const auto count : {loop.ticks, loop.overruns, loop.missed})
        row.push_back(static_cast<double>(count));
    rows.row(row);
  }
};

// How often which loop's ticks began how late, from the first to the last half octave in which any did.
std::string jitter_csv(const std::vector<std::pair<std::string, const JitterHistogram*>>& loops) {
  CsvWriter csv({"loop", "late_from_us", "late_to_us", "ticks"});
  for (const auto& [name, lateness] : loops) {
    const auto counts = lateness->half_octaves();
    std::size_t first = 0, end = counts.size();
    while (first < end && counts[first] == 0) ++first;
    while (end > first && counts[end - 1] == 0) --end;
    const auto edge_us = [](std::size_t i) {
      return number_text(1e-3 * static_cast<double>(JitterHistogram::half_octave_ns(i)));
    };
    for (std::size_t i = first; i < end; ++i)
      csv.row(std::vector<std::string>{name, edge_us(i), edge_us(i + 1), fmt::format("{}", counts[i])});
  }
  return csv.content();
}

// From the opened arm to the last figure. The loops end first: everything they touch is declared before them.
class PhysicsProcess {
 public:
  explicit PhysicsProcess(const PhysicsProcessOptions& options) : options_(options) {}

  Expected<Json> run();

 private:
  Expected<void> open();
  Expected<void> open_logs();
  Expected<void> begin_recording();
  Expected<Json> end_recording();
  void start_loops();
  void tell_what_load_can_do() const;
  Expected<void> watch();
  std::optional<transport::RecordingStatus> recording_status() const;
  void record_loops();
  void watch_guests();
  void let_guests_return();
  Json loops_figures() const;
  Json force_figures() const;
  Expected<void> finish_logs(const std::string& jitter);
  double up_s() const { return to_seconds(clock_.now() - start_); }

  const PhysicsProcessOptions& options_;
  const std::atomic<bool>& stop_ = stop_requested();
  MonotonicClock<PhysicsClock> clock_;
  MachineThreadClock guests_clock_;
  std::unique_ptr<record::session::PhysicsTicks> ticks_;  // null: nothing is recorded
  std::unique_ptr<PhysicsSide> side_;
  std::unique_ptr<record::session::SessionRecording> recording_;
  std::optional<record::session::PhysicsRecorder> recorder_;
  std::optional<haptics::TripWriter> trips_;
  Instant<PhysicsClock> start_;
  std::optional<LoopsLog> log_;
  std::optional<PhysicsLoops> loops_;
  GuestNews guests_;
  device::HealthMonitor<PhysicsClock> arm_health_{kLog};
};

Expected<Json> PhysicsProcess::run() {
  if (auto done = open(); !done) return tl::unexpected(done.error());
  start_ = clock_.now();
  if (auto done = open_logs(); !done) return tl::unexpected(done.error());
  if (auto done = begin_recording(); !done) return tl::unexpected(done.error());
  start_loops();
  const auto watched = watch();
  let_guests_return();
  loops_->stop();
  Json result = loops_figures();
  result["begun_monotonic_ns"] = clock_.to_monotonic(start_);
  const std::string jitter =
      jitter_csv({{"haptic", &loops_->haptic().lateness()}, {"physics", &loops_->physics().lateness()}});
  trips_->stop();
  if (recording_) {
    auto recorded = end_recording();
    if (!recorded) return recorded;
    result["recording"] = std::move(*recorded);
  }
  const auto counters = side_->service().counters();
  result["service"] = {{"endpoint", side_->service().endpoint()},
                       {"requests", counters.requests},
                       {"syncs", counters.syncs},
                       {"rejected", counters.rejected},
                       {"turned_away", counters.rejected_connections},
                       {"unsent", counters.unsent}};
  result["force"] = force_figures();
  const std::string failure = side_->server().trouble();
  result["application_failure"] = failure.empty() ? Json() : Json(failure);
  if (Json figures = side_->arm().figures(); !figures.is_null()) result["arm"] = std::move(figures);
  if (auto done = finish_logs(jitter); !done) return tl::unexpected(done.error());
  if (!watched) return tl::unexpected(watched.error());
  return result;
}

Expected<void> PhysicsProcess::open() {
  if (!options_.drivers.names_arm(options_.arm.uri))
    return wrong_use("--arm: {}", options_.drivers.check(options_.arm).error().message);
  auto place = serving_place(options_.endpoint, options_.insecure, options_.keys);
  if (!place) return tl::unexpected(place.error());
  auto side = PhysicsSide::open(options_, &guests_clock_);
  if (!side) return tl::unexpected(side.error());
  side_ = std::move(*side);
  if (auto served = side_->serve(place->endpoint, clock_, place->identity); !served) return served;
  const auto& permit = side_->server().haptic().permit();
  if (!permit.words().empty()) kLog.write(LogLevel::warning, permit.words());
  if (permit.given() && !options_.armed)
    kLog.info("forces stay off until somebody arms them: palpate status --reset, or R in a window");
  tell_who_is_admitted(*place, kLog);
  return {};
}

Expected<void> PhysicsProcess::open_logs() {
  const auto folder = options_.out.empty() ? run_directory() : Expected<std::filesystem::path>(options_.out);
  if (!folder) return tl::unexpected(folder.error());
  trips_.emplace(side_->server().haptic(), *folder, start_);
  auto log = LoopsLog::begin(options_.out);
  if (!log) return tl::unexpected(log.error());
  log_ = std::move(*log);
  return {};
}

Expected<void> PhysicsProcess::begin_recording() {
  if (options_.record.empty()) return {};
  auto begun =
      record::session::SessionRecording::begin(options_.record, {.recorder = "physics", .on_error = {}});
  if (!begun) return tl::unexpected(begun.error());
  recording_ = std::move(*begun);
  recording_->record_log();
  if (auto done = recording_->describe(kSetupWords, words_of(recorded_setup(options_, side_->arm(), true)));
      !done)
    return done;
  ticks_ = std::make_unique<record::session::PhysicsTicks>();
  side_->server().record_to(*ticks_);
  recorder_.emplace(*recording_, *ticks_, side_->server().haptic(), options_.rig, side_->scene(),
                    options_.rig_text);
  recorder_->record_shapes(
      [this](Instant<PhysicsClock> t, std::span<float> out) { return side_->server().shape_at(t, out); });
  recorder_->start();
  return {};
}

// The loops have ended. Figures of what the file holds; refused where the disk has refused.
Expected<Json> PhysicsProcess::end_recording() {
  recorder_->stop();
  auto figures = recording_->finish();
  if (figures) (*figures)["missed"] = recorder_->missed();
  return figures;
}

void PhysicsProcess::start_loops() {
  loops_.emplace(*side_, clock_,
                 LoopRates{.physics_hz = options_.physics_hz,
                           .haptic_hz = options_.haptic_hz,
                           .real_time = options_.real_time});
  tell_what_load_can_do();
  kLog.info("answers graphics servers at {}", side_->service().endpoint());
  if (const auto who = side_->arm().description(); !who.empty() && !side_->arm().health())
    kLog.write(LogLevel::info, who);
  if (options_.ready) options_.ready();
}

// Without real-time rights anything that works on this machine, or makes the network thread work, delays forces.
void PhysicsProcess::tell_what_load_can_do() const {
  const RealTimeGrant& grant = loops_->haptic().grant();
  if (!options_.real_time || grant.fifo()) return;
  kLog.warning(
      "warning: without real-time rights forces are not protected from load on this machine; `palpate "
      "doctor` "
      "says what to do");
}

// Until its time is over or somebody asks for the end; refused where the arm has gone for good.
Expected<void> PhysicsProcess::watch() {
  for (int look = 0; !stop_.load() && (options_.seconds <= 0.0 || up_s() < options_.seconds); ++look) {
    if (look % 10 == 0) loops_->write_status(up_s(), recording_status());
    if (recorder_ && look % 50 == 0) record_loops();
    watch_guests();
    if (log_)
      log_->look(up_s(), side_->service().counters(), loops_->haptic().statistics(),
                 loops_->physics().statistics());
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
    if (const auto there = side_->arm().look(); !there) return refused("physics: {}", there.error().message);
    arm_health_.follow(side_->arm().health(), clock_.now());
  }
  return {};
}

std::optional<transport::RecordingStatus> PhysicsProcess::recording_status() const {
  if (!recording_) return std::nullopt;
  return transport::RecordingStatus{up_s(), recording_->dropped(), recording_->ended()};
}

void PhysicsProcess::record_loops() {
  const auto us = [](Duration d) { return static_cast<double>(d.count()) * 1e-3; };
  for (const auto& [name, loop] :
       {std::pair("haptic", &loops_->haptic()), std::pair("physics", &loops_->physics())}) {
    const LoopStatistics s = loop->statistics();
    recorder_->write({.name = name,
                      .rate_hz = s.rate_hz,
                      .ticks = s.ticks,
                      .overruns = s.overruns,
                      .missed = s.missed,
                      .late_p50_us = us(s.late_p50),
                      .late_p99_us = us(s.late_p99),
                      .late_max_us = us(s.late_max)},
                     clock_.now());
  }
}

// A thread that a guest has taken comes back to nobody: then the server ends in words, and with it the threads.
void PhysicsProcess::watch_guests() {
  const GuestNews::Line line = guests_.look(side_->server(), loops_->watchdog().hangs());
  if (!line.text.empty()) kLog.write(line.last ? LogLevel::error : LogLevel::warning, line.text);
  if (!line.last) return;
  side_->server().let_go();
  std::fflush(nullptr);
  std::_Exit(1);
}

// A loop that a guest has taken cannot be waited for: at the end, too, it comes back or the process ends in words.
void PhysicsProcess::let_guests_return() {
  do {
    watch_guests();
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
  } while (guests_.hang());
}

Json PhysicsProcess::loops_figures() const {
  Json result;
  result["haptic"] = loop_json(loops_->haptic().statistics());
  result["haptic"]["scheduling"] = loops_->haptic().grant().describe();
  result["physics"] = loop_json(loops_->physics().statistics());
  return result;
}

Json PhysicsProcess::force_figures() const {
  auto& haptic = side_->server().haptic();  // its loop has ended
  const auto& statistics = haptic.statistics();
  const haptics::TripSummary taken = haptics::summary_of(trips_->log().trips());
  const MachineStalls& stalls = loops_->machine_stalls();
  std::uint64_t outages_then = 0, trips_then = 0;  // in stalls of the machine
  for (const haptics::LoggedTrip& trip : trips_->log().trips())
    if (within_stall(trip, stalls.stalls())) ++(trip.is_trip() ? trips_then : outages_then);
  Json figures = {{"peak_n", statistics.peak_n},
                  {"limited_ticks", statistics.limited_ticks},
                  {"peak_limited_ticks", statistics.peak_limited_ticks},
                  {"lost_impulse_rel", statistics.lost_impulse_rel()},
                  {"blows", statistics.impacts},
                  {"rejected_blows", statistics.rejected_impacts},
                  {"missed_blows", statistics.missed_impacts},
                  {"dropped_blows", statistics.dropped_impacts},
                  {"ticks", statistics.ticks},
                  {"outages", taken.outages},
                  {"condition", device::condition_text({haptic.state(), haptic.fault()})},
                  {"fault_ticks", statistics.fault_ticks},
                  {"warm_ticks", statistics.warm_ticks},
                  {"damped_ticks", statistics.damped_ticks},
                  {"trips", taken.trips},
                  {"trip_causes", taken.trip_causes},
                  {"outage_causes", taken.outage_causes},
                  {"longest_outage_ms", 1e3 * taken.longest_outage_s},
                  {"machine_stalls", stalls.count()},
                  {"longest_machine_stall_ms", 1e3 * to_seconds(stalls.longest())},
                  {"outages_in_machine_stalls", outages_then},
                  {"trips_in_machine_stalls", trips_then},
                  {"trip_files", trips_->written()}};
  if (statistics.law_ticks > 0) {
    const auto us = [&](double q) {
      return static_cast<double>(haptic.law_cost().quantile(q).count()) * 1e-3;
    };
    figures["contact_law"] = {{"ticks", statistics.law_ticks},
                              {"overruns", statistics.law_overruns},
                              {"bad_forces", statistics.law_bad_forces},
                              {"cost_us", {{"p50", us(0.5)}, {"p99", us(0.99)}, {"max", us(1.0)}}}};
  }
  figures["hangs"] = loops_->watchdog().times();
  return figures;
}

Expected<void> PhysicsProcess::finish_logs(const std::string& jitter) {
  if (!log_) return {};
  if (auto done = log_->rows.finish(); !done) return done;
  return write_file(options_.out / "realtime_jitter.csv", jitter);
}

}  // namespace

Expected<Json> run_physics_process(const PhysicsProcessOptions& options) {
  stop_requested();  // from here on a signal is a request
  keep_freed_memory();
  return PhysicsProcess(options).run();
}

}  // namespace palpate::server::physics
