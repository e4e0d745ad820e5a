#include <fmt/format.h>

#include "applications/scene_settings.h"
#include "applications/touched_mesh.h"
#include "palpate/core/child_report.h"
#include "palpate/core/json.h"
#include "palpate/server/physics/physics_process.h"
#include "palpate/sim/config/world_file.h"
#include "tools/commands/command.h"
#include "tools/commands/drivers.h"
#include "tools/commands/guests.h"
#include "tools/commands/touch_options.h"

namespace palpate::tools::commands {

void add_physics(CLI::App& program) {
  auto* command = program.add_subcommand(
      "physics", "The physics server: 1 kHz force loop, virtual world, states for graphics servers");
  struct Options {
    std::string rig = "rig.toml", lab = "lab", world, json;
    double extra_force_delay_ms = 0.0;
    TouchOptions touch;
    server::physics::PhysicsProcessOptions process;
  };
  auto options = std::make_shared<Options>();
  command->add_option("--rig", options->rig, "Calibrated rig file")->capture_default_str();
  command
      ->add_option("--app", options->process.scene.application,
                   "Application to run; `palpate apps` lists them")
      ->default_val("pingpong");
  command->add_option("--listen", options->process.endpoint,
                      "ZeroMQ address; the default is a socket private to this user (ipc://...)");
  command->add_option("--keys", options->process.keys, "Folder of keys for tcp://; see palpate keys");
  command->add_flag("--insecure", options->process.insecure,
                    "Serve tcp:// without keys: anyone who reaches it sees and commands");
  command
      ->add_option(
          "--arm", options->process.arm.uri,
          "lab (a simulated laboratory's), openhaptics or openhaptics:NAME (a real PHANToM or Touch, "
          "and no laboratory)")
      ->default_val("lab");
  command->add_flag("--arm-at-reset", options->process.arm.at_reset_position,
                    "The real arm is in its reset position now: set its encoders' zero there if it is lost");
  command->add_option("--lab", options->lab, "Name of the laboratory `palpate world run` serves")
      ->default_val("lab");
  command->add_option("--world", options->world,
                      "World file to take ball, bat, serve and touch settings from");
  add_touch_options(*command, options->touch);
  command->add_option("--seed", options->process.run.seed, "Seed of the serves")->default_val(1);
  command
      ->add_option(
          "--serve-pause-s", options->process.run.pause_s,
          "Ping-pong for people: this pause between serves, and rallies that last as long as the ball "
          "comes back; without, serves follow each other as the scripted player likes them")
      ->check(CLI::Range(0.0, 3600.0));
  command->add_option("--seconds", options->process.seconds, "Stop after this many seconds; 0 = at Ctrl-C")
      ->check(CLI::NonNegativeNumber)
      ->default_val(0.0);
  command
      ->add_option("--extra-force-delay-ms", options->extra_force_delay_ms,
                   "Give every force so much later, on purpose: for experiments")
      ->check(CLI::Range(0.0, 200.0));
  command->add_option("--physics-hz", options->process.physics_hz, "Rate of the physics loop")
      ->default_val(1000.0)
      ->check(CLI::Range(1000.0, 20000.0));
  command->add_option("--haptic-hz", options->process.haptic_hz, "Rate of the haptic loop")
      ->default_val(1000.0)
      ->check(CLI::Range(1000.0, 4000.0));
  command->add_option(
      "--out", options->process.out,
      "Folder for realtime_loops.csv and realtime_jitter.csv, there when the server has ended, and for "
      "trip_*.csv, the last seconds before forces were switched off (without --out: in the run folder)");
  command->add_option("--json", options->json,
                      "Write loop and exchange figures here at the end; - = standard output");
  on(command, [options, command]() -> Expected<void> {
    auto rig = rig::read_rig(options->rig);
    if (!rig) return tl::unexpected(rig.error());
    if (!rig->arm)
      return refused("{}: has no arm calibration; run `palpate calibrate arm ... --rig {}`", options->rig,
                     options->rig);
    options->process.rig = *rig;
    options->process.drivers = drivers();
    if (options->process.arm.uri == "lab") options->process.arm.uri += ":" + options->lab;
    const std::string application = options->process.scene.application;
    sim::config::WorldFile world = sim::config::reference_world();
    if (!options->world.empty()) {
      auto read = sim::config::read_world(options->world);
      if (!read) return tl::unexpected(read.error());
      world = *read;
    }
    if (auto ok = apply(options->touch, application, world); !ok) return ok;
    options->process.applications = known_applications();
    options->process.scene = applications::scene_settings(world, application);
    const auto mesh = applications::read_touched_mesh(options->process.scene);
    if (!mesh) return tl::unexpected(mesh.error());
    if (!mesh->empty()) notice("physics: " + *mesh);
    options->process.surface_restitution = world.ball.restitution_table;
    options->process.extra_force_delay =
        seconds(command->count("--extra-force-delay-ms") > 0 ? 1e-3 * options->extra_force_delay_ms
                                                             : world.display.extra_force_delay_s);
    if (!options->process.out.empty())
      if (auto made = make_folder(options->process.out); !made) return made;
    options->process.notice = notice;
    options->process.ready = tell_parent_ready;
    auto result = server::physics::run_physics_process(options->process);
    if (!result) return tl::unexpected(result.error());
    tell_parent_result(*result);
    if (!options->json.empty()) return write_json(options->json, *result);
    fmt::print(
        "haptic loop {:.0f} Hz, {} ticks left out, the latest of the others {:.0f} us late; {} states "
        "answered\n",
        (*result)["haptic"]["rate_hz"].get<double>(), (*result)["haptic"]["missed"].get<std::uint64_t>(),
        (*result)["haptic"]["jitter_us"]["max"].get<double>(),
        (*result)["service"]["requests"].get<std::uint64_t>());
    return {};
  });
}

}  // namespace palpate::tools::commands
