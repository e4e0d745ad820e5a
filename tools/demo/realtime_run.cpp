#include "tools/demo/realtime_run.h"

#include <unistd.h>

#include <chrono>
#include <thread>

#include "drivers/laboratory/channel.h"
#include "palpate/core/csv.h"
#include "palpate/core/file.h"
#include "palpate/evaluation/latency_probe.h"
#include "palpate/evaluation/outage_analysis.h"
#include "palpate/evaluation/realtime_overlay.h"
#include "palpate/transport/local_endpoint.h"
#include "tools/demo/child_process.h"

namespace palpate::tools::demo {
namespace {

using std::chrono::milliseconds;

// A person at the window plays as long as they like; one who has left it open for the night does not.
constexpr double kLongestVisit_s = 4.0 * 3600.0;
constexpr double kServePause_s = 0.8;  // between serves, for people
constexpr double kWarmUp_s = 1.0;  // clocks settle and the person takes the stylus; its pictures do not count

bool says(const std::filesystem::path& log, std::string_view words) {
  const auto text = read_file(log);
  return text && text->find(words) != std::string::npos;
}

Expected<Json> read_json(const std::filesystem::path& path) {
  auto text = read_file(path);
  if (!text) return tl::unexpected(text.error());
  Json json = Json::parse(*text, nullptr, false);
  if (json.is_discarded()) return refused("{}: is not JSON", path.string());
  return json;
}

// The physics server writes seconds since its own start; everything else of the run counts from the graphics
// server's.
Expected<void> shift_times(const std::filesystem::path& path, double by_s) {
  const auto table = read_csv(path);
  if (!table) return tl::unexpected(table.error());
  CsvWriter shifted(table->header);
  for (auto row : table->rows) {
    row.front() += by_s;
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
  const auto world = sim::config::read_world(options.world);
  if (!world) return tl::unexpected(world.error());
  const auto rig = rig::read_rig(options.rig);
  if (!rig) return tl::unexpected(rig.error());
  auto against = evaluation::overlay_case(*world, options.seed, *rig);
  against.warm_up_s = kWarmUp_s;
  return evaluation::evaluate_overlay(options.out / "realtime_poses.csv", options.out / "realtime_truth.csv",
                                      against);
}

}  // namespace

Expected<Json> run_realtime(const RealtimeRunOptions& options, const std::function<void(double)>& progress) {
  const std::string name = fmt::format("demo-{}", ::getpid());
  std::optional<TestNetwork> network;
  std::vector<std::string> listen, connect;
  if (options.two_hosts) {
    auto made = TestNetwork::make(name, *options.two_hosts);
    if (!made) return tl::unexpected(made.error());
    network.emplace(std::move(*made));
    listen = network->listen_options();
    connect = network->connect_options();
  } else {
    const auto endpoint = transport::default_endpoint(name);
    if (!endpoint) return tl::unexpected(endpoint.error());
    listen = {"--listen", endpoint->address};
    connect = {"--connect", endpoint->address};
  }
  const auto start_server = [&](TwoHosts::Host host, std::vector<std::string> list,
                                const std::vector<std::string>& where, const std::filesystem::path& log) {
    list.insert(list.end(), where.begin(), where.end());
    list.insert(list.end(), {"--world", options.world.string(), "--seed", std::to_string(options.seed)});
    return network ? network->start(host, options.program, list, log)
                   : ChildProcess::start(options.program, list, log);
  };
  const auto file = [&](const std::string& part, const std::string& ending) {
    return options.out / ("realtime_" + part + ending);
  };

  // A blinking panel in the view is nothing for a person who plays.
  const bool timecode = !options.window;
  // The laboratory outlives the run's length and is asked to stop at its end. It ends by itself, and the
  // physics server with it, where nobody is left to ask.
  const double patience = (options.window ? kLongestVisit_s : options.seconds) + 30.0;
  std::vector<std::string> world_list = {"world",       "run",
                                         "--name",      name,
                                         "--seconds",   fmt::format("{}", patience + 30.0),
                                         "--world",     options.world.string(),
                                         "--seed",      std::to_string(options.seed),
                                         "--exposures", file("truth", ".csv").string()};
  auto world = ChildProcess::start(options.program, world_list, file("world", ".log"));
  if (!world) return tl::unexpected(world.error());
  for (int i = 0;; ++i) {
    if (progress) progress(0.0);
    if (drivers::laboratory::LabClient::open(name)) break;
    if (!world->running())
      return refused("real-time leg: the laboratory ended (exit {}): {}", *world->wait({}),
                     last_words(file("world", ".log")));
    if (i > 1000) return refused("real-time leg: the laboratory did not open its devices within 10 s");
    std::this_thread::sleep_for(milliseconds(10));
  }
  std::vector<std::string> physics_list = {"physics",
                                           "--rig",
                                           options.rig.string(),
                                           "--app",
                                           options.application,
                                           "--lab",
                                           name,
                                           "--out",
                                           options.out.string(),
                                           "--json",
                                           file("physics", ".json").string()};
  if (options.window)
    physics_list.insert(physics_list.end(), {"--serve-pause-s", fmt::format("{}", kServePause_s)});
  auto physics = start_server(TwoHosts::kPhysicsHost, physics_list, listen, file("physics", ".log"));
  if (!physics) return tl::unexpected(physics.error());
  std::vector<std::string> graphics_list = {"graphics",
                                            "--rig",
                                            options.rig.string(),
                                            "--quality",
                                            std::string(render::quality_word(options.quality)),
                                            "--lab",
                                            name,
                                            "--player",
                                            "--seconds",
                                            fmt::format("{}", options.seconds),
                                            "--disguise-offset-s",
                                            fmt::format("{:.9f}", options.graphics_clock.offset_s),
                                            "--disguise-drift-ppm",
                                            fmt::format("{:.6f}", options.graphics_clock.drift * 1e6),
                                            "--out",
                                            options.out.string(),
                                            "--json",
                                            file("graphics", ".json").string()};
  if (timecode) graphics_list.emplace_back("--clock-strip");
  if (options.window) graphics_list.insert(graphics_list.end(), {"--window", "--mouse"});
  if (options.window && options.monitor)
    graphics_list.insert(graphics_list.end(),
                         {"--monitor", std::string(desktop::monitor_view_word(*options.monitor))});
  auto graphics = start_server(TwoHosts::kGraphicsHost, graphics_list, connect, file("graphics", ".log"));
  if (!graphics) return tl::unexpected(graphics.error());

  const auto begun = std::chrono::steady_clock::now();
  const double before_s = options.two_hosts ? 0.5 * (options.seconds - options.two_hosts->cut_s) : 0.0;
  bool playing = false;
  while (true) {
    const auto code = graphics->wait(milliseconds(network ? 10 : 100));
    if (network && !playing) playing = says(file("graphics", ".log"), "graphics: shows");
    if (playing)
      if (auto looked = network->look(before_s); !looked) return tl::unexpected(looked.error());
    const double elapsed = std::chrono::duration<double>(std::chrono::steady_clock::now() - begun).count();
    if (progress) progress(elapsed / (options.seconds + 1.0));
    if (code && *code != 0)
      return refused("real-time leg: the graphics server ended (exit {}): {}", *code,
                     last_words(file("graphics", ".log")));
    if (code) break;
    if (!physics->running())
      return refused("real-time leg: the physics server ended (exit {}): {}", *physics->wait({}),
                     last_words(file("physics", ".log")));
    if (elapsed > patience)
      return refused("real-time leg: the graphics server did not end within {:.0f} s", patience);
  }
  physics->ask_to_stop();
  const auto code = physics->wait(std::chrono::seconds(5));
  if (!code || *code != 0)
    return refused("real-time leg: the physics server did not end in order: {}",
                   last_words(file("physics", ".log")));
  world->ask_to_stop();
  world->wait(std::chrono::seconds(5));

  auto from_graphics = read_json(file("graphics", ".json"));
  if (!from_graphics) return tl::unexpected(from_graphics.error());
  auto from_physics = read_json(file("physics", ".json"));
  if (!from_physics) return tl::unexpected(from_physics.error());
  const auto begun_ns = [](const Json& json) { return json["begun_monotonic_ns"].get<std::int64_t>(); };
  if (auto done = shift_times(options.out / "realtime_loops.csv",
                              1e-9 * static_cast<double>(begun_ns(*from_physics) - begun_ns(*from_graphics)));
      !done)
    return tl::unexpected(done.error());
  Json result = *from_graphics;
  result.erase("begun_monotonic_ns");
  result.erase("server_there");
  // A laboratory that had to be killed has told nothing: then delay and pictures stand without a judgement.
  if (std::filesystem::exists(file("truth", ".csv")) && result["exchange"]["frames"] > 0) {
    if (timecode) {
      auto judged = evaluation::evaluate_latency(options.out / "realtime_photons.csv", file("truth", ".csv"),
                                                 options.scan_out);
      if (judged) result["photon_to_photon"].update(*judged);  // none where no timecode could be read
    }
    auto overlay = evaluate_pictures(options);
    if (!overlay) return tl::unexpected(overlay.error());
    result["overlay"] = *overlay;
  }
  if (network) {
    auto told = tell_network(*network, options.out, *from_graphics);
    if (!told) return tl::unexpected(told.error());
    result["network"] = *told;
  }
  result["haptic"] = (*from_physics)["haptic"];
  result["physics"] = (*from_physics)["physics"];
  result["force"] = (*from_physics)["force"];
  for (const std::string part : {"world", "physics", "graphics"}) {
    std::error_code ignored;
    std::filesystem::remove(file(part, ".log"), ignored);
    std::filesystem::remove(file(part, ".json"), ignored);
  }
  return result;
}

}  // namespace palpate::tools::demo
