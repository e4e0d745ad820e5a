#include "palpate/server/physics/physics_process.h"

#include <fmt/format.h>

#include <atomic>
#include <cstdio>
#include <cstdlib>
#include <memory>
#include <mutex>
#include <optional>
#include <thread>
#include <utility>

#include "palpate/core/crash_words.h"
#include "palpate/core/csv.h"
#include "palpate/core/csv_file.h"
#include "palpate/core/file.h"
#include "palpate/core/run_directory.h"
#include "palpate/core/stop_signal.h"
#include "palpate/haptics/trip_writer.h"
#include "palpate/server/physics/guest_news.h"
#include "palpate/server/physics/internal/arm_check.h"
#include "palpate/server/physics/loop_watchdog.h"
#include "palpate/server/physics/physics_server.h"
#include "palpate/time/periodic_loop.h"
#include "palpate/transport/zmq_engine.h"

namespace palpate::server::physics {
namespace {

// The keys an encrypted endpoint needs.
Expected<std::optional<transport::ServerIdentity>> identity_for(const transport::Endpoint& endpoint,
                                                                const std::filesystem::path& chosen) {
  if (!endpoint.encrypted) return std::nullopt;
  const auto folder = chosen.empty() ? transport::keys_folder() : Expected<std::filesystem::path>(chosen);
  if (!folder) return tl::unexpected(folder.error());
  auto identity = transport::server_identity(*folder);
  if (!identity) return tl::unexpected(identity.error());
  return std::optional(std::move(*identity));
}

// What a person should know of who may come in.
void tell_who_is_admitted(const transport::Endpoint& endpoint,
                          const std::optional<transport::ServerIdentity>& identity,
                          const std::function<void(const std::string&)>& notice) {
  if (!notice) return;
  if (!endpoint.local() && !identity)
    notice(fmt::format(
        "physics: warning: {} is neither encrypted nor guarded: whoever reaches it sees and commands",
        endpoint.address));
  if (!identity) return;
  notice("physics: key of this server " + identity->own.public_key);
  const auto admitted =
      transport::read_authorized_keys(identity->folder).value_or(transport::AuthorizedKeys{});
  for (const auto& complaint : admitted.complaints) notice("physics: warning: " + complaint);
  if (admitted.keys.empty())
    notice("physics: warning: nobody is admitted yet; `palpate keys authorize` admits");
}

Json loop_json(const LoopStatistics& loop, double elapsed_s) {
  const auto us = [](Duration d) { return static_cast<double>(d.count()) * 1e-3; };
  return {{"rate_hz", elapsed_s > 0 ? static_cast<double>(loop.ticks) / elapsed_s : 0.0},
          {"ticks", loop.ticks},
          {"overruns", loop.overruns},
          {"missed", loop.missed},
          {"missed_in_a_row", loop.missed_in_a_row},
          {"jitter_us", {{"p50", us(loop.late_p50)}, {"p99", us(loop.late_p99)}, {"max", us(loop.late_max)}}},
          {"busy_us", {{"p50", us(loop.busy_p50)}, {"p99", us(loop.busy_p99)}, {"max", us(loop.busy_max)}}}};
}

// Lines for a person from another thread, until the main one passes them on.
class Told {
 public:
  void add(const std::string& line) {
    const std::lock_guard lock(mutex_);
    lines_.push_back(line);
  }
  std::vector<std::string> take() {
    const std::lock_guard lock(mutex_);
    return std::exchange(lines_, {});
  }

 private:
  std::mutex mutex_;
  std::vector<std::string> lines_;
};

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
  explicit PhysicsProcess(const PhysicsProcessOptions& options)
      : options_(options), scene_(scene_from_rig(options.rig, options.scene, options.surface_restitution)) {}

  Expected<Json> run();

 private:
  Expected<void> open();
  haptics::HapticSettings haptic_settings() const;
  Expected<void> serve(const transport::Endpoint& endpoint,
                       std::optional<transport::ServerIdentity> identity);
  Expected<void> open_logs();
  void start_loops();
  Expected<void> watch();
  void watch_guests();
  void look_at_the_loops();
  void pass_on_lines();
  Json loops_figures(double elapsed_s) const;
  Json force_figures() const;
  Expected<void> finish_logs(const std::string& jitter);
  double up_s() const { return to_seconds(clock_.now() - start_); }
  void notice(const std::string& line) const {
    if (options_.notice) options_.notice("physics: " + line);
  }

  const PhysicsProcessOptions& options_;
  const std::atomic<bool>& stop_ = stop_requested();
  scene::SceneDescription scene_;
  std::unique_ptr<device::OpenedArm> arm_;
  MonotonicClock<PhysicsClock> clock_;
  MachineThreadClock guests_clock_;
  std::optional<PhysicsServer> server_;
  transport::StatusBoard board_;
  std::unique_ptr<transport::StateService> service_;
  Told told_;
  std::optional<haptics::TripWriter> trips_;
  Instant<PhysicsClock> start_;
  std::optional<LoopsLog> log_;
  std::optional<PeriodicLoop<PhysicsClock>> haptic_, physics_;
  std::optional<LoopWatchdog> watchdog_;
  GuestNews guests_;
};

Expected<Json> PhysicsProcess::run() {
  if (auto done = open(); !done) return tl::unexpected(done.error());
  start_ = clock_.now();
  if (auto done = open_logs(); !done) return tl::unexpected(done.error());
  start_loops();
  const auto watched = watch();
  const double elapsed_s = up_s();
  watchdog_->stop();
  haptic_->stop();
  physics_->stop();
  say_crashes(nullptr, nullptr);  // there is no arm any more that could let go
  Json result = loops_figures(elapsed_s);
  result["begun_monotonic_ns"] = clock_.to_monotonic(start_);
  const std::string jitter =
      jitter_csv({{"haptic", &haptic_->lateness()}, {"physics", &physics_->lateness()}});
  trips_->stop();
  pass_on_lines();
  const auto counters = service_->counters();
  result["service"] = {{"endpoint", service_->endpoint()},
                       {"requests", counters.requests},
                       {"syncs", counters.syncs},
                       {"rejected", counters.rejected},
                       {"turned_away", counters.rejected_connections},
                       {"unsent", counters.unsent}};
  result["force"] = force_figures();
  if (Json figures = arm_->figures(); !figures.is_null()) result["arm"] = std::move(figures);
  if (auto done = finish_logs(jitter); !done) return tl::unexpected(done.error());
  if (!watched) return tl::unexpected(watched.error());
  return result;
}

Expected<void> PhysicsProcess::open() {
  auto application = options_.applications.make_physics(scene_, options_.run);
  if (!application) return tl::unexpected(application.error());
  auto endpoint =
      options_.endpoint.empty()
          ? transport::default_endpoint()
          : transport::parse_endpoint(options_.endpoint, transport::EndpointUse::listen, options_.insecure);
  if (!endpoint) return tl::unexpected(endpoint.error());
  auto identity = identity_for(*endpoint, options_.keys);
  if (!identity) return tl::unexpected(identity.error());
  device::ArmRequest request = options_.arm;
  request.nominal = options_.rig.nominal_arm;
  if (!options_.drivers.names_arm(request.uri))
    return wrong_use("--arm: {}", options_.drivers.check(request).error().message);
  auto arm = options_.drivers.open(request);
  if (!arm) return tl::unexpected(arm.error());
  if (auto fine = check_arm(options_.rig, **arm, request.uri); !fine) return tl::unexpected(fine.error());
  arm_ = std::move(*arm);
  server_.emplace(options_.rig, scene_, std::move(*application), arm_->device(), haptic_settings(),
                  &guests_clock_);
  server_->delay_forces(options_.extra_force_delay);
  scene_.shape_vertices = server_->shape_vertices();
  return serve(*endpoint, std::move(*identity));
}

haptics::HapticSettings PhysicsProcess::haptic_settings() const {
  haptics::HapticSettings settings;
  settings.period = seconds(1.0 / options_.haptic_hz);
  if (options_.rig.arm) settings.limits = haptics::force_limits_of(options_.rig.arm->model);
  settings.limits = haptics::lowered_to(settings.limits, arm_->facts());
  return settings;
}

Expected<void> PhysicsProcess::serve(const transport::Endpoint& endpoint,
                                     std::optional<transport::ServerIdentity> identity) {
  auto service = transport::serve_states(
      endpoint, clock_, [this](Instant<PhysicsClock> t) { return server_->state_at(t); }, scene_,
      {.identity = identity,
       .status = [this] { return board_.read(); },
       .shape = [this](Instant<PhysicsClock> t, std::span<float> out) { return server_->shape_at(t, out); }});
  if (!service) return tl::unexpected(service.error());
  service_ = std::move(*service);
  const auto folder = options_.out.empty() ? run_directory() : Expected<std::filesystem::path>(options_.out);
  if (!folder) return tl::unexpected(folder.error());
  trips_.emplace(server_->haptic(), *folder, [this](const std::string& line) { told_.add(line); });
  tell_who_is_admitted(endpoint, identity, options_.notice);
  return {};
}

Expected<void> PhysicsProcess::open_logs() {
  auto log = LoopsLog::begin(options_.out);
  if (!log) return tl::unexpected(log.error());
  log_ = std::move(*log);
  return {};
}

void PhysicsProcess::start_loops() {
  haptic_.emplace(clock_,
                  PeriodicLoopSettings{.rate_hz = options_.haptic_hz,
                                       .name = "palpate-haptic",
                                       .real_time = options_.real_time,
                                       .priority = 80,
                                       .keep_cores_awake = true},
                  [this](Instant<PhysicsClock> t) { server_->haptic_tick(t); });
  // The physics loop sleeps only: two loops that spin would starve each other on a small machine.
  physics_.emplace(clock_,
                   PeriodicLoopSettings{.rate_hz = options_.physics_hz,
                                        .name = "palpate-physics",
                                        .real_time = options_.real_time,
                                        .priority = 70,
                                        .spin = Duration(0)},
                   [this](Instant<PhysicsClock> t) {
                     while (const auto control = service_->take_control()) server_->control(*control);
                     server_->physics_tick(t);
                   });
  watchdog_.emplace(clock_, server_->haptic(), options_.real_time);
  say_crashes([](void* server) noexcept { static_cast<PhysicsServer*>(server)->let_go(); }, &*server_);
  notice(fmt::format("answers graphics servers at {}", service_->endpoint()));
  if (options_.ready) options_.ready();
}

// Until its time is over or somebody asks for the end; refused where the arm has gone for good.
Expected<void> PhysicsProcess::watch() {
  for (int look = 0; !stop_.load() && (options_.seconds <= 0.0 || up_s() < options_.seconds); ++look) {
    if (look % 10 == 0) look_at_the_loops();
    pass_on_lines();
    watch_guests();
    if (log_) log_->look(up_s(), service_->counters(), haptic_->statistics(), physics_->statistics());
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
    const auto news = arm_->look();
    if (!news) return refused("physics: {}", news.error().message);
    if (*news) notice(**news);
  }
  return {};
}

// A thread that a guest has taken comes back to nobody: then the server ends in words, and with it the threads.
void PhysicsProcess::watch_guests() {
  const GuestNews::Line line = guests_.look(*server_, watchdog_->hangs());
  if (!line.text.empty()) notice(line.text);
  if (!line.last) return;
  server_->let_go();
  std::fflush(nullptr);
  std::_Exit(1);
}

void PhysicsProcess::look_at_the_loops() {
  transport::LoopStatus force_loop = transport::loop_status("haptic", *haptic_, up_s());
  force_loop.condition = server_->condition_words();
  board_.write({.uptime_s = up_s(),
                .loops = {std::move(force_loop), transport::loop_status("physics", *physics_, up_s())}});
}

void PhysicsProcess::pass_on_lines() {
  for (const auto& line : told_.take()) notice(line);
}

Json PhysicsProcess::loops_figures(double elapsed_s) const {
  Json result;
  result["haptic"] = loop_json(haptic_->statistics(), elapsed_s);
  result["haptic"]["scheduling"] = haptic_->grant().describe();
  result["physics"] = loop_json(physics_->statistics(), elapsed_s);
  return result;
}

Json PhysicsProcess::force_figures() const {
  const auto& haptic = std::as_const(*server_).haptic();
  const auto& statistics = haptic.statistics();
  Json figures = {{"peak_n", statistics.peak_n},
                  {"limited_ticks", statistics.limited_ticks},
                  {"peak_limited_ticks", statistics.peak_limited_ticks},
                  {"lost_impulse_rel", statistics.lost_impulse_rel()},
                  {"blows", statistics.impacts},
                  {"rejected_blows", statistics.rejected_impacts},
                  {"missed_blows", statistics.missed_impacts},
                  {"dropped_blows", statistics.dropped_impacts},
                  {"outages", statistics.outages},
                  {"condition", haptics::condition_text(haptic.state(), haptic.fault())},
                  {"fault_ticks", statistics.fault_ticks},
                  {"warm_ticks", statistics.warm_ticks},
                  {"damped_ticks", statistics.damped_ticks},
                  {"trips", haptic.condition().trips},
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
  figures["hangs"] = watchdog_->times();
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
