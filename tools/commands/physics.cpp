#include <fmt/format.h>

#include "palpate/core/child_report.h"
#include "palpate/core/file.h"
#include "palpate/core/json.h"
#include "palpate/scene/mesh_asset.h"
#include "palpate/server/physics/physics_process.h"
#include "palpate/sim/config/world_scene.h"
#include "tools/commands/checks.h"
#include "tools/commands/command.h"
#include "tools/commands/drivers.h"
#include "tools/commands/guests.h"
#include "tools/commands/settings_options.h"

namespace palpate::tools::commands {
namespace {

struct PhysicsOptions {
  std::string rig = "rig.toml", lab = "lab", application, world, json;
  double extra_force_delay_ms = 0.0;
  SettingsOptions settings;
  server::physics::PhysicsProcessOptions process;
};

void add_place_options(CLI::App& command, PhysicsOptions& options) {
  command.add_option("--listen", options.process.endpoint,
                     "ZeroMQ address; the default is a socket private to this user (ipc://...)");
  command.add_option("--keys", options.process.keys, "Folder of keys for tcp://; see palpate keys");
  command.add_flag("--insecure", options.process.insecure,
                   "Serve tcp:// without keys: anyone who reaches it sees and commands");
  command
      .add_option(
          "--arm", options.process.arm.uri,
          "lab (a simulated laboratory's), or a real one, and no laboratory: openhaptics[:NAME] (PHANToM, "
          "Touch), haply[:ID] (Inverse3), forcedimension[:SERIAL] (omega, delta, sigma, lambda, Falcon)")
      ->default_val("lab");
  command.add_flag("--arm-at-reset", options.process.arm.at_reset_position,
                   "The real arm is in its reset position now: set its encoders' zero there if it is lost");
  command.add_flag_callback(
      "--disarmed", [&options] { options.process.armed = false; },
      "Forces stay off until somebody arms them (palpate status --reset, or R in a window): for a server "
      "that "
      "something else than a person starts");
  command.add_option("--lab", options.lab, "Name of the laboratory `palpate world run` serves")
      ->default_val("lab");
}

void add_game_options(CLI::App& command, PhysicsOptions& options) {
  command.add_option("--world", options.world, "World file to take the application's settings from");
  add_settings_options(command, options.settings, known_applications());
  command.add_option("--seed", options.process.run.seed, "Seed of the application, of its serves")
      ->default_val(1);
  command
      .add_option(
          "--serve-pause-s", options.process.run.pause_s,
          "For people: this pause between serves, and rallies that last as long as the ball comes back; "
          "without, serves follow each other as the scripted player likes them")
      ->check(between(0.0, 3600.0));
  command.add_option("--seconds", options.process.seconds, "Stop after this many seconds; 0 = at Ctrl-C")
      ->check(at_least_zero())
      ->default_val(0.0);
}

void add_loop_options(CLI::App& command, PhysicsOptions& options) {
  command
      .add_option("--extra-force-delay-ms", options.extra_force_delay_ms,
                  "Give every force so much later, on purpose: for experiments")
      ->check(between(0.0, 200.0));
  command.add_option("--physics-hz", options.process.physics_hz, "Rate of the physics loop")
      ->default_val(1000.0)
      ->check(between(1000.0, 20000.0));
  command.add_option("--haptic-hz", options.process.haptic_hz, "Rate of the haptic loop")
      ->default_val(1000.0)
      ->check(between(1000.0, 4000.0));
  command.add_option(
      "--out", options.process.out,
      "Folder for realtime_loops.csv and realtime_jitter.csv, there when the server has ended, and for "
      "trip_*.csv, the last seconds before forces were switched off (without --out: in the run folder)");
  command
      .add_option("--record", options.process.record,
                  "Record the session in this new file (MCAP; palpate recording)")
      ->type_name("FILE");
  command.add_option("--json", options.json,
                     "Write loop and exchange figures here at the end; - = standard output");
}

Expected<void> choose_scene(PhysicsOptions& options, bool delay_said) {
  auto& process = options.process;
  process.applications = known_applications();
  auto world = world_of(options.world, process.applications);
  if (!world) return tl::unexpected(world.error());
  if (auto ok = apply(options.settings, process.applications, options.application, world->settings); !ok)
    return ok;
  auto scene = sim::config::scene_of(*world, process.applications, options.application);
  if (!scene) return tl::unexpected(scene.error());
  process.scene = std::move(*scene);
  const auto mesh = scene::read_mesh_asset(process.scene);
  if (!mesh) return tl::unexpected(mesh.error());
  if (!mesh->empty()) notice("physics: " + *mesh);
  process.extra_force_delay =
      seconds(delay_said ? 1e-3 * options.extra_force_delay_ms : world->display.extra_force_delay_s);
  return {};
}

Expected<void> serve_physics(PhysicsOptions& options, bool delay_said) {
  auto& process = options.process;
  auto rig = rig::read_rig(options.rig);
  if (!rig) return tl::unexpected(rig.error());
  if (!rig->arm)
    return refused("{}: has no arm calibration; run `palpate calibrate arm ... --rig {}`", options.rig,
                   options.rig);
  process.rig = *rig;
  process.rig_text = read_file(options.rig).value_or("");
  process.drivers = drivers();
  if (process.arm.uri == "lab") {
    if (auto there = laboratory_of_desk(*rig, options.rig, options.lab); !there) return there;
    process.arm.uri += ":" + options.lab;
  }
  if (auto chosen = choose_scene(options, delay_said); !chosen) return chosen;
  if (!process.out.empty())
    if (auto made = make_folder(process.out); !made) return made;
  process.ready = tell_parent_ready;
  auto result = server::physics::run_physics_process(process);
  if (!result) return tl::unexpected(result.error());
  tell_parent_result(*result);
  // Its figures are those of what it did until then.
  const Json& failure = (*result)["application_failure"];
  const auto outcome =
      failure.is_null() ? Expected<void>() : refused("physics: {}", failure.get<std::string>());
  if (!options.json.empty()) {
    if (auto done = write_json(options.json, *result); !done) return done;
    return outcome;
  }
  fmt::print(
      "haptic loop {:.0f} Hz, {} ticks left out, the latest of the others {:.0f} us late; {} states "
      "answered\n",
      (*result)["haptic"]["rate_hz"].get<double>(), (*result)["haptic"]["missed"].get<std::uint64_t>(),
      (*result)["haptic"]["jitter_us"]["max"].get<double>(),
      (*result)["service"]["requests"].get<std::uint64_t>());
  return outcome;
}

}  // namespace

void add_physics(CLI::App& program) {
  auto* command = program.add_subcommand(
      "physics", "The physics server: 1 kHz force loop, virtual world, states for graphics servers");
  auto options = std::make_shared<PhysicsOptions>();
  command->add_option("--rig", options->rig, "Calibrated rig file")->capture_default_str();
  add_application_option(*command, options->application);
  add_place_options(*command, *options);
  add_game_options(*command, *options);
  add_loop_options(*command, *options);
  on(command,
     [options, command] { return serve_physics(*options, command->count("--extra-force-delay-ms") > 0); });
}

}  // namespace palpate::tools::commands
