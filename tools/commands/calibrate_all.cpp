#include <fmt/format.h>

#include "palpate/calibration/session/calibration_session.h"
#include "palpate/calibration/session/landmark_finder.h"
#include "palpate/core/file.h"
#include "palpate/core/progress.h"
#include "palpate/core/units.h"
#include "palpate/evaluation/world_sample.h"
#include "palpate/server/graphics/frame_renderer.h"
#include "palpate/sim/camera_renderer.h"
#include "tools/commands/command.h"
#include "tools/commands/guests.h"

namespace palpate::tools::commands {
void add_calibrate_all(CLI::App& calibrate) {
  auto* command = calibrate.add_subcommand(
      "all", "All of it through the devices of a simulated laboratory; goes on where an earlier run stopped");
  struct Options {
    std::string rig, world;
    std::uint64_t seed = 1;
  };
  auto options = std::make_shared<Options>();
  command->add_option("--rig", options->rig, "Rig file: written after each step; what it has already is kept")
      ->required();
  command->add_option("--world", options->world, "World file; the reference laboratory where none is named");
  command->add_option("--seed", options->seed, "Draws the laboratory's imperfections and noise")
      ->capture_default_str();
  on(command, [options]() -> Expected<void> {
    sim::config::WorldFile file = sim::config::reference_world();
    if (!options->world.empty()) {
      auto read = sim::config::read_world(options->world, known_applications());
      if (!read) return tl::unexpected(read.error());
      file = *read;
    }
    rig::Rig rig;
    if (is_there(options->rig)) {
      auto read = rig::read_rig(options->rig);
      if (!read) return tl::unexpected(read.error());
      rig = *read;
    }
    rig.nominal_arm.lengths = {file.arm.lengths[0], file.arm.lengths[1]};
    rig.tip_marker_leds = file.tip_marker.leds;
    rig.camera_marker_leds = file.camera_marker.leds;
    rig.pointer_leds = file.pointer.leds;
    sim::CameraRenderer renderer;
    sim::Simulator world(file, options->seed);
    world.set_renderer([&renderer](const sim::TrueView& view, std::vector<std::uint8_t>& rgb) {
      renderer.render(view, rgb);
    });
    Progress progress({{"calibrating", 25.0}});
    calibration::session::SessionHooks hooks;
    calibration::session::GuidanceState guidance;
    hooks.progress = [&progress](std::size_t step, std::size_t steps, const std::string& name) {
      progress.begin(0);
      progress.say(name);
      progress.update(static_cast<double>(step) / static_cast<double>(steps));
    };
    hooks.guidance = [&progress, &guidance](const calibration::session::GuidanceState& state, int of) {
      guidance = state;
      progress.say(
          fmt::format("arm: pose {} of {}, {}", state.poses, of, calibration::session::guidance_text(state)));
    };
    hooks.save = [&options](const rig::Rig& so_far) { return rig::write_rig(options->rig, so_far); };
    hooks.find_landmarks = calibration::session::landmark_finder();
    calibration::session::CalibrationPlan plan;
    plan.reach = evaluation::reach_of(file);
    plan.guidance_seed = options->seed;
    plan.date = rig::utc_now();
    auto done = calibration::session::calibrate_rig(evaluation::laboratory_of(world), rig, plan, hooks);
    progress.finish();
    if (!done) return tl::unexpected(done.error());
    fmt::print("{}: complete; held-out error of the arm {:.3f} mm\n", one_line(options->rig),
               mm_from_metres(rig.arm->held_out_mean));
    if (guidance.poses > 0)
      fmt::print("arm: {} guided poses, {}\n", guidance.poses, calibration::session::guidance_text(guidance));
    return {};
  });
}

}  // namespace palpate::tools::commands
