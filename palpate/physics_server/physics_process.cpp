#include "palpate/physics_server/physics_process.h"

#include <fmt/format.h>

#include <mutex>
#include <thread>
#include <utility>

#include "palpate/applications/applications.h"
#include "palpate/core/csv.h"
#include "palpate/core/csv_file.h"
#include "palpate/core/file.h"
#include "palpate/core/run_directory.h"
#include "palpate/core/stop_signal.h"
#include "palpate/haptics/trip_writer.h"
#include "palpate/network/zmq_engine.h"
#include "palpate/physics_server/physics_server.h"
#include "palpate/time/periodic_loop.h"

namespace palpate {
namespace {

// The keys an encrypted endpoint needs.
Expected<std::optional<ServerIdentity>> identity_for(const Endpoint& endpoint,
                                                     const std::filesystem::path& chosen) {
  if (!endpoint.encrypted) return std::nullopt;
  const auto folder = chosen.empty() ? keys_folder() : Expected<std::filesystem::path>(chosen);
  if (!folder) return tl::unexpected(folder.error());
  auto identity = server_identity(*folder);
  if (!identity) return tl::unexpected(identity.error());
  return std::optional(std::move(*identity));
}

// What a person should know of who may come in.
void tell_who_is_admitted(const Endpoint& endpoint, const std::optional<ServerIdentity>& identity,
                          const std::function<void(const std::string&)>& notice) {
  if (!notice) return;
  if (!endpoint.local() && !identity)
    notice(fmt::format(
        "physics: warning: {} is neither encrypted nor guarded: whoever reaches it sees and commands",
        endpoint.address));
  if (!identity) return;
  notice("physics: key of this server " + identity->own.public_key);
  const auto admitted = read_authorized_keys(identity->folder).value_or(AuthorizedKeys{});
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

  void look(double time_s, const ServiceCounters& service, const LoopStatistics& haptic,
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

}  // namespace

Expected<Json> run_physics_process(const PhysicsProcessOptions& options) {
  const auto& stop = stop_requested();
  keep_freed_memory();
  SceneDescription scene = scene_from_rig(options.rig, options.scene, options.surface_restitution);
  auto application = make_application(scene, options.seed, options.serve_pause_s);
  if (!application) return tl::unexpected(application.error());
  auto endpoint = options.endpoint.empty()
                      ? default_endpoint()
                      : parse_endpoint(options.endpoint, EndpointUse::listen, options.insecure);
  if (!endpoint) return tl::unexpected(endpoint.error());
  auto identity = identity_for(*endpoint, options.keys);
  if (!identity) return tl::unexpected(identity.error());
  ArmChoice choice = options.arm;
  choice.lengths = options.rig.nominal_lengths;
  auto arm = open_arm(choice);
  if (!arm) return tl::unexpected(arm.error());

  MonotonicClock<PhysicsClock> clock;
  HapticSettings haptic_settings;
  haptic_settings.period = seconds(1.0 / options.haptic_hz);
  if (options.rig.arm) haptic_settings.limits = force_limits_of(options.rig.arm->model);
  haptic_settings.limits = (*arm)->limits(haptic_settings.limits);
  PhysicsServer server(options.rig, scene, std::move(*application), (*arm)->device(), haptic_settings);
  server.delay_forces(options.extra_force_delay);
  scene.shape_vertices = server.shape_vertices();
  StatusBoard board;
  auto service =
      serve_states(*endpoint, clock, [&server](Instant<PhysicsClock> t) { return server.state_at(t); }, scene,
                   {.identity = *identity,
                    .status = [&board] { return board.read(); },
                    .shape = [&server](Instant<PhysicsClock> t,
                                       std::span<float> out) { return server.shape_at(t, out); }});
  if (!service) return tl::unexpected(service.error());

  const auto trip_folder =
      options.out.empty() ? run_directory() : Expected<std::filesystem::path>(options.out);
  if (!trip_folder) return tl::unexpected(trip_folder.error());
  Told told;
  TripWriter trips(server.haptic(), *trip_folder, [&told](const std::string& line) { told.add(line); });
  const auto pass_on = [&] {
    for (const auto& line : told.take())
      if (options.notice) options.notice("physics: " + line);
  };

  const auto start = clock.now();
  Json result;
  result["begun_monotonic_ns"] = clock.to_monotonic(start);
  std::string gone;
  auto log = LoopsLog::begin(options.out);
  if (!log) return tl::unexpected(log.error());
  std::string jitter;
  {
    PeriodicLoop<PhysicsClock> haptic(clock,
                                      {.rate_hz = options.haptic_hz,
                                       .name = "palpate-haptic",
                                       .real_time = options.real_time,
                                       .priority = 80,
                                       .keep_cores_awake = true},
                                      [&](Instant<PhysicsClock> t) { server.haptic_tick(t); });
    // The physics loop sleeps only: two loops that spin would starve each other on a small machine.
    PeriodicLoop<PhysicsClock> physics(clock,
                                       {.rate_hz = options.physics_hz,
                                        .name = "palpate-physics",
                                        .real_time = options.real_time,
                                        .priority = 70,
                                        .spin = Duration(0)},
                                       [&](Instant<PhysicsClock> t) {
                                         while (const auto wish = (*service)->take_control())
                                           server.control(*wish);
                                         server.physics_tick(t);
                                       });
    tell_who_is_admitted(*endpoint, *identity, options.notice);
    if (options.notice)
      options.notice(fmt::format("physics: answers graphics servers at {}", (*service)->endpoint()));
    const auto look_at_the_loops = [&] {
      const double up = to_seconds(clock.now() - start);
      LoopStatus force_loop = loop_status("haptic", haptic, up);
      const HapticCondition condition = server.haptic().condition();
      force_loop.condition = condition_text(condition.state, condition.fault);
      board.write({.uptime_s = up, .loops = {std::move(force_loop), loop_status("physics", physics, up)}});
    };
    for (int look = 0;
         !stop.load() && (options.seconds <= 0.0 || to_seconds(clock.now() - start) < options.seconds);
         ++look) {
      if (look % 10 == 0) look_at_the_loops();
      pass_on();
      if (*log)
        (*log)->look(to_seconds(clock.now() - start), (*service)->counters(), haptic.statistics(),
                     physics.statistics());
      std::this_thread::sleep_for(std::chrono::milliseconds(20));
      const auto news = (*arm)->look();
      if (!news) {
        gone = news.error().message;
        break;
      }
      if (*news && options.notice) options.notice("physics: " + **news);
    }
    const double elapsed = to_seconds(clock.now() - start);
    haptic.stop();
    physics.stop();
    result["haptic"] = loop_json(haptic.statistics(), elapsed);
    result["haptic"]["scheduling"] = haptic.grant().describe();
    result["physics"] = loop_json(physics.statistics(), elapsed);
    jitter = jitter_csv({{"haptic", &haptic.lateness()}, {"physics", &physics.lateness()}});
  }
  trips.stop();
  pass_on();
  const auto counters = (*service)->counters();
  const auto& statistics = server.haptic().statistics();
  result["service"] = {{"endpoint", (*service)->endpoint()},
                       {"requests", counters.requests},
                       {"syncs", counters.syncs},
                       {"rejected", counters.rejected},
                       {"turned_away", counters.turned_away},
                       {"unsent", counters.unsent}};
  result["force"] = {{"peak_n", statistics.peak_n},
                     {"limited_ticks", statistics.limited_ticks},
                     {"peak_limited_ticks", statistics.peak_limited_ticks},
                     {"lost_impulse_rel", statistics.lost_impulse_rel()},
                     {"blows", statistics.blows},
                     {"rejected_blows", statistics.rejected_blows},
                     {"missed_blows", statistics.missed_blows},
                     {"condition", condition_text(server.haptic().state(), server.haptic().fault())},
                     {"fault_ticks", statistics.fault_ticks},
                     {"warm_ticks", statistics.warm_ticks},
                     {"damped_ticks", statistics.damped_ticks},
                     {"trips", server.haptic().condition().trips},
                     {"trip_files", trips.written()}};
  if (Json figures = (*arm)->figures(); !figures.is_null()) result["arm"] = std::move(figures);
  if (*log) {
    if (auto done = (*log)->rows.finish(); !done) return tl::unexpected(done.error());
    if (auto done = write_file(options.out / "realtime_jitter.csv", jitter); !done)
      return tl::unexpected(done.error());
  }
  if (!gone.empty()) return refused("physics: {}", gone);
  return result;
}

}  // namespace palpate
