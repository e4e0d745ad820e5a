#include <fmt/format.h>

#include <cmath>

#include "palpate/calibration/session/calibration_session.h"
#include "palpate/calibration/session/landmark_finder.h"
#include "palpate/core/file.h"
#include "palpate/core/progress.h"
#include "palpate/core/stop_signal.h"
#include "palpate/core/units.h"
#include "palpate/evaluation/world_sample.h"
#include "palpate/server/graphics/frame_renderer.h"
#include "palpate/sim/camera_renderer.h"
#include "palpate/sim/truth_rig.h"
#include "tools/commands/calibrate_live.h"
#include "tools/commands/checks.h"
#include "tools/commands/command.h"
#include "tools/commands/device_recording.h"
#include "tools/commands/guests.h"
#include "tools/commands/lens_file.h"
#include "tools/commands/result_output.h"

namespace palpate::tools::commands {
namespace {

// A person's session; the rig file says which arm and markers there are.
Expected<void> calibrate_named(const LiveDevices& devices, const std::string& file, const rig::Rig& rig,
                               const ForceArguments& forces, std::uint64_t seed, int poses,
                               device::LensKind lens) {
  if (!is_there(file))
    return wrong_use("--rig {}: no such file; `palpate rig new {}` makes one, for your arm and markers", file,
                     file);
  calibration::session::CalibrationPlan plan;
  plan.guidance_seed = seed;
  plan.arm_points = plan.arm_test_points = poses;
  plan.lens = lens;
  plan.now = rig::utc_now;
  return calibrate_live(devices, file, rig, plan, forces);
}

struct CalibrateAllOptions {
  std::string rig, world, lens;
  std::uint64_t seed = 1;
  int poses = calibration::session::CalibrationPlan().arm_points;
  LiveDevices devices;
  ForceArguments forces;
};

// By itself, in the simulated laboratory of a world file.
Expected<void> calibrate_simulated(const CalibrateAllOptions& options, const sim::config::WorldFile& file,
                                   rig::Rig rig) {
  rig.nominal_arm = sim::makers_arm(file);
  rig.tip_marker_leds = file.tip_marker.leds;
  rig.camera_marker_leds = file.camera_marker.leds;
  rig.pointer_leds = file.pointer.leds;
  fmt::print("no --arm, --tracker and --camera: the simulated laboratory is calibrated, by itself{}\n",
             is_there(options.rig)
                 ? fmt::format("; what {} has already is kept, and right only where it is of that laboratory",
                               one_line(options.rig))
                 : "");
  sim::CameraRenderer renderer;
  sim::Simulator world(file, options.seed);
  const double away = rig.arm ? sim::away_from_laboratory(*rig.arm, world) : 0.0;
  const bool of_another = std::isfinite(away) && away > sim::kOtherLaboratory;
  if (of_another)
    notice(fmt::format(
        "warning: the arm in {} is {:.0f} mm from the one of this laboratory (--seed {}): what is kept was "
        "calibrated in another; go on with its --seed and --world, or name a new file",
        one_line(options.rig), 1e3 * away, options.seed));
  auto recorded = DeviceRecording::begin(options.devices.record, "calibrate all", rig, true);
  if (!recorded) return tl::unexpected(recorded.error());
  world.set_renderer(
      [&renderer](const sim::TrueView& view, std::vector<std::uint8_t>& rgb) { renderer.render(view, rgb); });
  Progress progress({{"calibrating", 25.0}});
  progress.begin(0);
  calibration::session::SessionHooks hooks;
  calibration::session::GuidanceState guidance;
  hooks.progress = [&progress](std::size_t step, std::size_t steps, const std::string& name) {
    progress.say(name);
    progress.update(static_cast<double>(step) / static_cast<double>(steps));
  };
  hooks.guidance = [&progress, &guidance](const calibration::session::GuidanceState& state, int of) {
    guidance = state;
    progress.say(
        fmt::format("arm: pose {} of {}, {}", state.poses, of, calibration::session::guidance_text(state)));
  };
  hooks.save = [&options](const rig::Rig& so_far) { return rig::write_rig(options.rig, so_far); };
  hooks.find_landmarks = calibration::session::landmark_finder();
  calibration::session::CalibrationPlan plan;
  plan.reach = evaluation::reach_of(file);
  plan.lens = device::lens_kind(options.lens.empty() ? file.camera.lens : options.lens).value_or(plan.lens);
  plan.guidance_seed = options.seed;
  plan.arm_points = plan.arm_test_points = options.poses;
  plan.now = [] { return rig::kSimulatedDate; };
  hooks.recorded = [&recorded, &rig](const calibration::session::CalibrationRecordings& recordings) {
    recorded->keep_tables(recordings, rig);
  };
  auto context = recorded->recorded(evaluation::laboratory_of(world));
  context.stop = &stop_requested();
  auto done = calibration::session::calibrate_rig(context, rig, plan, hooks);
  progress.finish();
  if (auto whole = recorded->finish(rig); !whole) return whole;
  if (!done) return tl::unexpected(done.error());
  fmt::print("{}: complete, {}; held-out error of the arm {:.3f} mm\n", one_line(options.rig),
             of_another ? "with parts of another laboratory"
                        : fmt::format("of the simulated laboratory (--seed {})", options.seed),
             mm_from_metres(rig.arm->held_out_mean));
  if (guidance.poses > 0)
    fmt::print("arm: {} guided poses, {}\n", guidance.poses, calibration::session::guidance_text(guidance));
  return {};
}

}  // namespace

void add_calibrate_all(CLI::App& calibrate) {
  auto* command = calibrate.add_subcommand("all",
                                           "All of it, step by step: with you at the devices that --arm, "
                                           "--tracker and --camera name, or by itself in a "
                                           "simulated laboratory; goes on where an earlier run stopped");
  auto options = std::make_shared<CalibrateAllOptions>();
  command->add_option("--rig", options->rig, "Rig file: written after each step; what it has already is kept")
      ->required();
  command->add_option("--world", options->world, "World file; the reference laboratory where none is named");
  command->add_option("--seed", options->seed, "Draws the laboratory's imperfections and noise")
      ->capture_default_str();
  command
      ->add_option(
          "--poses", options->poses,
          "In how many poses the stylus is held for the arm, and as many again that judge the result")
      ->check(between(15, 1000))
      ->capture_default_str();
  add_lens_model_option(*command, options->lens);
  add_device_options(*command, options->devices);
  add_record_options(*command, options->devices.record);
  add_force_options(*command, options->forces);
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
    if (options->devices.window && !options->devices.named()) return window_without_devices();
    if (options->devices.named())
      return calibrate_named(options->devices, options->rig, rig, options->forces, options->seed,
                             options->poses, lens_model(options->lens, rig));
    return calibrate_simulated(*options, file, std::move(rig));
  });
}

}  // namespace palpate::tools::commands
