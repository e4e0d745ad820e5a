#include "tools/demo/realtime_run.h"

#include <unistd.h>

#include <chrono>
#include <thread>

#include "palpate/core/child_process.h"
#include "palpate/core/csv.h"
#include "palpate/core/file.h"
#include "palpate/evaluation/latency_probe.h"
#include "palpate/evaluation/outage_analysis.h"
#include "palpate/evaluation/realtime_overlay.h"
#include "palpate/transport/local_endpoint.h"
#include "tools/demo/session_processes.h"

namespace palpate::tools::demo {
namespace {

using std::chrono::milliseconds;

// A person at the window plays as long as they like; one who has left it open for the night does not.
constexpr double kLongestVisit_s = 4.0 * 3600.0;
constexpr double kPause_s = 0.8;   // between two rounds, for people
constexpr double kWarmUp_s = 1.0;  // clocks settle and the person takes the stylus; its pictures do not count

// The physics server writes seconds since its own start; everything else of the run counts from the graphics
// server's.
Expected<void> shift_times(const std::filesystem::path& path, double by_s) {
  CsvOptions some_text;
  some_text.text_columns = {"*"};
  const auto table = read_csv(path, some_text);
  if (!table) return tl::unexpected(table.error());
  CsvWriter shifted(table->header);
  for (std::size_t i = 0; i < table->rows.size(); ++i) {
    auto row = table->text[i];
    row.front() = number_text(table->rows[i].front() + by_s);
    shifted.row(row);
  }
  return write_file(path, shifted.content());
}

Expected<Json> tell_network(const TestNetwork& network, const std::filesystem::path& out,
                            const Json& graphics) {
  const auto cut = network.cut();
  if (!cut) return tl::unexpected(cut.error());
  const auto begun = graphics["begun_monotonic_ns"].get<std::int64_t>();
  const auto since = [begun](std::int64_t ns) { return 1e-9 * static_cast<double>(ns - begun); };
  evaluation::NetworkRecords records;
  records.encrypted = network.encrypted();
  records.physics_address = network.address();
  records.graphics_place = TwoHosts::kPlaces[TwoHosts::kGraphicsHost];
  records.pulled_s = since(cut->pulled_ns);
  records.plugged_s = since(cut->plugged_ns);
  for (const auto& change : graphics["server_there"])
    records.server_there.push_back({change["time_s"].get<double>(), change["there"].get<bool>()});
  CsvOptions some_text;
  some_text.text_columns = {"*"};
  for (const auto& [name, table] :
       {std::pair("realtime_frames.csv", &records.frames), std::pair("realtime_sync.csv", &records.sync),
        std::pair("realtime_loops.csv", &records.loops)}) {
    auto read = read_csv(out / name, some_text);
    if (!read) return tl::unexpected(read.error());
    *table = std::move(*read);
  }
  if (auto done = write_file(out / "realtime_network.csv", evaluation::network_events(records)); !done)
    return tl::unexpected(done.error());
  return evaluation::outage_analysis(records);
}

// What the servers never see comes in only now: world file and seed say where everything truly was.
Expected<Json> evaluate_pictures(const RealtimeRunOptions& options) {
  const auto world = sim::config::read_world(options.world, options.applications);
  if (!world) return tl::unexpected(world.error());
  const auto rig = rig::read_rig(options.rig);
  if (!rig) return tl::unexpected(rig.error());
  auto against = evaluation::overlay_case(*world, options.seed, *rig);
  against.warm_up_s = kWarmUp_s;
  return evaluation::evaluate_overlay(options.out / "realtime_poses.csv", options.out / "realtime_truth.csv",
                                      against);
}

// Three processes from their start to their figures. Whatever fails ends all of them.
class RealtimeRun {
 public:
  RealtimeRun(const RealtimeRunOptions& options, const std::function<void(double)>& progress)
      : options_(options),
        progress_(progress),
        name_(fmt::format("demo-{}", ::getpid())),
        patience_((options.window ? kLongestVisit_s : options.seconds) + 30.0) {}

  Expected<Json> run();

 private:
  Expected<void> choose_addresses();
  Expected<void> start_laboratory();
  Expected<void> start_physics();
  Expected<void> start_graphics();
  Expected<void> watch();
  Expected<void> stop();
  Expected<Json> figures();
  Expected<void> judge(Json& result);
  void remove_logs() const;

  SessionProcesses processes() const;
  Expected<ChildProcess> start_server(TwoHosts::Host host, const std::vector<std::string>& arguments,
                                      const std::string& part) const;
  // Of a process that was not to end yet.
  Expected<void> still_runs(ChildProcess& process, const char* which) const;
  std::filesystem::path file(const std::string& part, const std::string& ending) const {
    return options_.out / ("realtime_" + part + ending);
  }
  // A blinking panel in the view is nothing for a person who plays.
  bool timecode() const { return !options_.window; }

  const RealtimeRunOptions& options_;
  const std::function<void(double)>& progress_;
  std::string name_;  // of the laboratory, and of this run
  double patience_;   // s
  std::optional<TestNetwork> network_;
  SessionProcesses session_;
  // In this order they are started, and the other way round they end.
  std::optional<ChildProcess> laboratory_, physics_, graphics_;
  Json from_physics_, from_graphics_;
};

Expected<Json> RealtimeRun::run() {
  for (const auto step :
       {&RealtimeRun::choose_addresses, &RealtimeRun::start_laboratory, &RealtimeRun::start_physics,
        &RealtimeRun::start_graphics, &RealtimeRun::watch, &RealtimeRun::stop})
    if (auto done = (this->*step)(); !done) return tl::unexpected(done.error());
  return figures();
}

// The laboratory outlives the run's length and is asked to stop at its end. It ends by itself, and the physics
// server with it, where nobody is left to ask.
SessionProcesses RealtimeRun::processes() const {
  SessionProcesses session;
  session.name = name_;
  session.rig = options_.rig;
  session.world = options_.world;
  session.seed = options_.seed;
  session.out = options_.out;
  session.laboratory = {.seconds = patience_ + 30.0, .exposures = file("truth", ".csv")};
  session.physics.application = options_.application;
  if (options_.window) session.physics.pause_s = kPause_s;
  session.graphics.quality = options_.quality;
  session.graphics.player = true;
  session.graphics.seconds = options_.seconds;
  session.graphics.clock = options_.graphics_clock;
  session.graphics.timecode = timecode();
  session.graphics.window = options_.window;
  session.graphics.headset = options_.headset;
  if (options_.window) session.graphics.monitor = options_.monitor;
  session.physics.record = options_.recording.physics();
  session.graphics.record = options_.recording.graphics();
  session.graphics.pictures = options_.recorded_pictures;
  return session;
}

Expected<void> RealtimeRun::choose_addresses() {
  session_ = processes();
  if (options_.two_hosts) {
    auto made = TestNetwork::make(name_, *options_.two_hosts);
    if (!made) return tl::unexpected(made.error());
    network_.emplace(std::move(*made));
    session_.physics.listen = network_->listen();
    session_.graphics.connect = network_->connect();
    return {};
  }
  const auto endpoint = transport::default_endpoint(name_);
  if (!endpoint) return tl::unexpected(endpoint.error());
  session_.physics.listen.address = session_.graphics.connect.address = endpoint->address;
  return {};
}

Expected<void> RealtimeRun::still_runs(ChildProcess& process, const char* which) const {
  if (process.running()) return {};
  return refused("real-time run: the {} ended (exit {}): {}", which, *process.wait({}),
                 process.why_it_ended());
}

Expected<void> RealtimeRun::start_laboratory() {
  auto started = ChildProcess::start(options_.program, laboratory_arguments(session_), file("world", ".log"));
  if (!started) return tl::unexpected(started.error());
  laboratory_.emplace(std::move(*started));
  for (int i = 0; !laboratory_->reports().ready(); ++i) {
    if (progress_) progress_(0.0);
    if (auto runs = still_runs(*laboratory_, "laboratory"); !runs) return runs;
    if (i > 1000) return refused("real-time run: the laboratory did not open its devices within 10 s");
    std::this_thread::sleep_for(milliseconds(10));
  }
  return {};
}

Expected<ChildProcess> RealtimeRun::start_server(TwoHosts::Host host,
                                                 const std::vector<std::string>& arguments,
                                                 const std::string& part) const {
  return network_ ? network_->start(host, options_.program, arguments, file(part, ".log"))
                  : ChildProcess::start(options_.program, arguments, file(part, ".log"));
}

Expected<void> RealtimeRun::start_physics() {
  auto started = start_server(TwoHosts::kPhysicsHost, physics_arguments(session_), "physics");
  if (!started) return tl::unexpected(started.error());
  physics_.emplace(std::move(*started));
  // An application may have to get ready first, for half a minute and more; graphics would not wait for so long.
  while (!physics_->reports().ready()) {
    if (progress_) progress_(0.0);
    if (auto runs = still_runs(*physics_, "physics server"); !runs) return runs;
    std::this_thread::sleep_for(milliseconds(10));
  }
  return {};
}

Expected<void> RealtimeRun::start_graphics() {
  auto started = start_server(TwoHosts::kGraphicsHost, graphics_arguments(session_), "graphics");
  if (!started) return tl::unexpected(started.error());
  graphics_.emplace(std::move(*started));
  return {};
}

// Until the graphics server has shown what it was to show.
Expected<void> RealtimeRun::watch() {
  const auto begun = std::chrono::steady_clock::now();
  const double before_s = options_.two_hosts ? 0.5 * (options_.seconds - options_.two_hosts->cut_s) : 0.0;
  while (true) {
    const auto code = graphics_->wait(milliseconds(network_ ? 10 : 100));
    const bool playing = graphics_->reports().ready();
    if (network_ && playing)
      if (auto looked = network_->look(before_s); !looked) return looked;
    const double elapsed = std::chrono::duration<double>(std::chrono::steady_clock::now() - begun).count();
    if (progress_) progress_(elapsed / (options_.seconds + 1.0));
    if (code && *code != 0) return still_runs(*graphics_, "graphics server");
    if (code) return {};
    if (auto runs = still_runs(*physics_, "physics server"); !runs) return runs;
    if (elapsed > patience_)
      return refused("real-time run: the graphics server did not end within {:.0f} s", patience_);
  }
}

Expected<void> RealtimeRun::stop() {
  physics_->ask_to_stop();
  // An application may be preparing what comes next, and ends when it has.
  constexpr std::chrono::seconds kPatience{30};
  const auto code = physics_->wait(kPatience);
  if (!code) return refused("real-time run: the physics server did not end within {} s", kPatience.count());
  if (const auto& told = physics_->reports().result(); told && (*told)["application_failure"].is_string())
    return refused("real-time run: {}", (*told)["application_failure"].get<std::string>());
  if (*code != 0) return still_runs(*physics_, "physics server");
  laboratory_->ask_to_stop();
  laboratory_->wait(std::chrono::seconds(5));
  for (auto* server : {&*graphics_, &*physics_})
    if (!server->reports().result())
      return refused("real-time run: a server ended without its figures: {}", server->why_it_ended());
  from_graphics_ = *graphics_->reports().result();
  from_physics_ = *physics_->reports().result();
  return options_.recording.join();
}

Expected<Json> RealtimeRun::figures() {
  const auto begun_ns = [](const Json& json) { return json["begun_monotonic_ns"].get<std::int64_t>(); };
  const double later_s = 1e-9 * static_cast<double>(begun_ns(from_physics_) - begun_ns(from_graphics_));
  for (const char* name : {"realtime_loops.csv", "realtime_trips.csv"})
    if (std::filesystem::exists(options_.out / name))
      if (auto done = shift_times(options_.out / name, later_s); !done) return tl::unexpected(done.error());
  Json result = from_graphics_;
  result.erase("begun_monotonic_ns");
  result.erase("server_there");
  if (auto done = judge(result); !done) return tl::unexpected(done.error());
  if (network_) {
    auto told = tell_network(*network_, options_.out, from_graphics_);
    if (!told) return tl::unexpected(told.error());
    result["network"] = *told;
  }
  for (const char* part : {"haptic", "physics", "force"}) result[part] = from_physics_[part];
  remove_logs();
  return result;
}

// A laboratory that had to be killed has told nothing: then delay and pictures stand without a judgement.
Expected<void> RealtimeRun::judge(Json& result) {
  if (!std::filesystem::exists(file("truth", ".csv")) || result["exchange"]["frames"] == 0) return {};
  if (timecode()) {
    auto judged = evaluation::evaluate_latency(options_.out / "realtime_photons.csv", file("truth", ".csv"),
                                               options_.scan_out);
    if (judged) result["photon_to_photon"].update(*judged);  // none where no timecode could be read
  }
  auto overlay = evaluate_pictures(options_);
  if (!overlay) return tl::unexpected(overlay.error());
  result["overlay"] = *overlay;
  return {};
}

void RealtimeRun::remove_logs() const {
  for (const std::string part : {"world", "physics", "graphics"}) {
    std::error_code ignored;
    std::filesystem::remove(file(part, ".log"), ignored);
  }
}

}  // namespace

Expected<Json> run_realtime(const RealtimeRunOptions& options, const std::function<void(double)>& progress) {
  return RealtimeRun(options, progress).run();
}

}  // namespace palpate::tools::demo
