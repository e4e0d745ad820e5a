// palpate lockstep: a session in the simulated laboratory on the virtual clock, as figures and as a recording.
#include <fmt/format.h>

#include <memory>

#include "palpate/core/child_report.h"
#include "palpate/core/json.h"
#include "palpate/core/progress.h"
#include "palpate/core/stop_signal.h"
#include "palpate/scene/setting_text.h"
#include "palpate/scene/settings_file.h"
#include "palpate/sim/lockstep/lockstep_session.h"
#include "tools/commands/checks.h"
#include "tools/commands/command.h"
#include "tools/commands/guests.h"
#include "tools/commands/settings_options.h"

namespace palpate::tools::commands {
namespace {

struct LockstepArguments {
  sim::lockstep::SessionRequest session;
  SettingsOptions settings;
  std::vector<std::string> set;
  std::string world, rig = "truth", json;
  bool quiet = false, force_delay_said = false, picture_delay_said = false;
  double force_delay_ms = 0.0, picture_delay_ms = 0.0, player_delay_ms = 0.0;
  double network_delay_ms = 0.15, network_jitter_ms = 0.05;
};

struct StoppedByPerson {};

Expected<void> choose_world(const LockstepArguments& options, sim::lockstep::SessionRequest& session) {
  auto world = world_of(options.world, session.applications);
  if (!world) return tl::unexpected(world.error());
  session.world = std::move(*world);
  auto& values = session.world.settings;
  if (auto fine = apply(options.settings, session.applications, session.application, values); !fine)
    return fine;
  const auto& schema = session.applications.find(session.application)->settings;
  for (const auto& said : options.set)
    if (auto fine = scene::set_by_text(schema, said, values); !fine) return fine;
  scene::resolve_files(".", values);
  if (options.force_delay_said) session.world.display.extra_force_delay_s = 1e-3 * options.force_delay_ms;
  if (options.picture_delay_said)
    session.world.display.extra_picture_delay_s = 1e-3 * options.picture_delay_ms;
  return {};
}

Expected<void> run_lockstep(const LockstepArguments& options) {
  sim::lockstep::SessionRequest session = options.session;
  session.applications = known_applications();
  if (auto chosen = choose_world(options, session); !chosen) return chosen;
  if (options.rig != "truth") {
    auto rig = rig::read_rig(options.rig);
    if (!rig) return tl::unexpected(rig.error());
    session.rig = std::move(*rig);
  }
  session.player_extra_delay_s = 1e-3 * options.player_delay_ms;
  session.channel.delay = seconds(1e-3 * options.network_delay_ms);
  session.channel.jitter = seconds(1e-3 * options.network_jitter_ms);
  end_with_parent();  // a sweep that was killed leaves no plays behind
  Progress progress({{"playing", 1.0}});
  progress.begin(0);
  session.progress = [&progress, &stop = stop_requested()](double share) {
    if (stop.load()) throw StoppedByPerson{};
    progress.update(share);
  };
  try {
    const auto outcome = sim::lockstep::run_session(session);
    progress.finish();
    if (!outcome) return tl::unexpected(outcome.error());
    if (!options.quiet)
      for (const auto& line : outcome->lines)
        print_line(fmt::format("{:<9} {}", line.about + ":", line.text), stderr);
    return write_json(options.json, outcome->figures);
  } catch (const StoppedByPerson&) {
    progress.finish();
    return refused(ErrorCode::stopped, "lockstep: stopped before its end; there are no figures");
  }
}

void add_delays(CLI::App& command, LockstepArguments& options) {
  command
      .add_option("--extra-force-delay-ms", options.force_delay_ms,
                  "Forces come so much later, on purpose (default: as the world file says)")
      ->check(between(0.0, 200.0));
  command
      .add_option("--extra-picture-delay-ms", options.picture_delay_ms,
                  "Pictures come so much later, on purpose (default: as the world file says)")
      ->check(between(0.0, 1000.0));
  command
      .add_option("--player-delay-ms", options.player_delay_ms,
                  "The scripted player sees everything so much later")
      ->check(between(0.0, 1000.0))
      ->capture_default_str();
  command.add_option("--network-delay-ms", options.network_delay_ms, "Between the two servers, one way")
      ->check(between(0.0, 1000.0))
      ->capture_default_str();
  command
      .add_option("--network-jitter-ms", options.network_jitter_ms,
                  "On top of it, drawn for each message; the mean")
      ->check(between(0.0, 1000.0))
      ->capture_default_str();
  command.add_option("--network-loss", options.session.channel.loss, "Share of the messages that are lost")
      ->check(between(0.0, 1.0))
      ->capture_default_str();
}

}  // namespace

void add_lockstep(CLI::App& program) {
  auto* command = program.add_subcommand(
      "lockstep", "Play an application in the simulated laboratory on the virtual clock, without pictures");
  auto options = std::make_shared<LockstepArguments>();
  add_application_option(*command, options->session.application);
  command->add_option("--seconds", options->session.seconds, "Length of the play")
      ->default_val(10.0)
      ->check(between(0.1, 3600.0));
  command
      ->add_option("--seed", options->session.seed,
                   "Draws the laboratory's imperfections, noise, delays and the player")
      ->default_val(1);
  command->add_option("--world", options->world, "World file; the reference laboratory where none is named");
  command
      ->add_option("--rig", options->rig,
                   "Calibrated rig file of this world and seed, or truth: without errors of calibration")
      ->capture_default_str();
  add_settings_options(*command, options->settings, known_applications());
  command
      ->add_option("--set", options->set,
                   "A setting of the application by its name, such as SECTION.KEY=1.5; may be given again")
      ->type_name("NAME=VALUE");
  add_delays(*command, *options);
  command
      ->add_option("--record", options->session.record,
                   "New file for all states and forces of the play (MCAP)")
      ->type_name("FILE.mcap");
  command->add_flag("--quiet", options->quiet, "Nothing on standard error but what goes wrong");
  command->add_option("--json", options->json, "Figures, - for standard output")
      ->type_name("FILE")
      ->default_val("-");
  on(command, [options, command] {
    options->force_delay_said = command->count("--extra-force-delay-ms") > 0;
    options->picture_delay_said = command->count("--extra-picture-delay-ms") > 0;
    return run_lockstep(*options);
  });
}

}  // namespace palpate::tools::commands
