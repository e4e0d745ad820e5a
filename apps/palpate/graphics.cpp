#include <fmt/format.h>

#include "apps/palpate/command.h"
#include "apps/palpate/server_options.h"
#include "palpate/core/json.h"
#include "palpate/system/graphics_process.h"

namespace palpate::app {

void add_graphics(CLI::App& program) {
  auto* command = program.add_subcommand(
      "graphics", "The graphics server: camera and tracker in, augmented picture out (no window yet)");
  struct Options {
    std::string rig, world, json;
    GraphicsProcessOptions process;
  };
  auto options = std::make_shared<Options>();
  command->add_option("--rig", options->rig, "Calibrated rig file")->required();
  add_server_options(*command, options->process.server);
  command->add_option("--lab", options->process.lab, "Name of the laboratory `palpate world run` serves")
      ->default_val("lab");
  command->add_flag("--player", options->process.player, "Let the scripted player hold the stylus");
  command->add_option("--world", options->world,
                      "World file of that laboratory: how the scripted player's hand and arm feel");
  command->add_option("--seed", options->process.seed, "Seed of the scripted player")->default_val(1);
  command->add_option("--seconds", options->process.seconds, "Stop after this many seconds; 0 = at Ctrl-C")
      ->check(CLI::NonNegativeNumber)
      ->default_val(0.0);
  command
      ->add_option("--disguise-offset-s", options->process.disguise_offset_s,
                   "Show this machine's clock with an offset, to try the clock synchronisation")
      ->default_val(0.0);
  command->add_option("--disguise-drift-ppm", options->process.disguise_drift_ppm, "... and with a drift")
      ->default_val(0.0);
  command->add_option("--out", options->process.out,
                      "Folder for realtime_frames.csv and realtime_sync.csv, written at the end");
  command->add_option("--json", options->json,
                      "Write exchange and clock figures here at the end; - = standard output");
  on(command, [options]() -> Expected<void> {
    auto rig = read_rig(options->rig);
    if (!rig) return tl::unexpected(rig.error());
    if (!rig->arm || !rig->camera || !rig->hand_eye)
      return refused(
          "{}: arm, camera or hand-eye calibration is missing; run `palpate calibrate all --rig {}`",
          options->rig, options->rig);
    options->process.rig = *rig;
    options->process.world = sim::reference_world();
    if (!options->world.empty()) {
      auto world = sim::read_world(options->world);
      if (!world) return tl::unexpected(world.error());
      options->process.world = *world;
    }
    if (!options->process.out.empty())  // now, not after an hour of play
      if (auto made = make_folder(options->process.out); !made) return made;
    options->process.notice = notice;
    auto result = run_graphics_process(options->process);
    if (!result) return tl::unexpected(result.error());
    if (!options->json.empty()) return write_json(options->json, *result);
    fmt::print("{} frames at {:.1f} Hz, {} late; round trip {:.0f} us median\n",
               (*result)["exchange"]["frames"].get<std::uint64_t>(),
               (*result)["graphics"]["rate_hz"].get<double>(),
               (*result)["exchange"]["late"].get<std::uint64_t>(),
               (*result)["exchange"]["round_trip_us"]["median"].get<double>());
    return {};
  });
}

}  // namespace palpate::app
