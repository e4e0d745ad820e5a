// palpate play: a game on a desk, with any webcam, a printed board and the mouse.
#include <fmt/format.h>

#include <filesystem>
#include <memory>

#include "palpate/core/file.h"
#include "palpate/core/json.h"
#include "palpate/desktop/window.h"
#include "tools/commands/camera_options.h"
#include "tools/commands/checks.h"
#include "tools/commands/command.h"
#include "tools/commands/drivers.h"
#include "tools/commands/guests.h"
#include "tools/commands/record_options.h"
#include "tools/commands/settings_options.h"
#include "tools/demo/desk_play.h"

namespace palpate::tools::commands {
namespace {

struct PlayArguments {
  std::string rig = "desk.rig.toml", camera = "v4l2", quality = "auto", monitor, json;
  CameraOptions camera_options;
  RecordOptions record;
  SettingsOptions settings;
  demo::DeskPlayOptions play;
};

Expected<void> play(PlayArguments& options) {
  options.play.graphics.applications = known_applications();
  auto chosen = world_of("", options.play.graphics.applications);
  if (!chosen) return tl::unexpected(chosen.error());
  // What the person sets counts more.
  const auto* played = options.play.graphics.applications.find(options.play.application);
  if (played != nullptr && played->ease_for_a_person) played->ease_for_a_person(chosen->settings);
  if (auto fine = apply(options.settings, options.play.graphics.applications, options.play.application,
                        chosen->settings);
      !fine)
    return fine;
  options.play.settings = std::move(chosen->settings);
  const auto quality = render::parse_quality_choice(options.quality);
  if (!quality) return tl::unexpected(quality.error());
  if (!options.monitor.empty()) {
    const auto view = desktop::parse_monitor_view(options.monitor);
    if (!view) return tl::unexpected(view.error());
    options.play.graphics.monitor = *view;
  }
  auto request = camera_request(drivers(), options.camera, options.camera_options);
  if (!request) return tl::unexpected(request.error());
  auto rig = rig::read_rig(options.rig);
  if (!rig) return tl::unexpected(rig.error());
  if (!rig->board)
    return refused("{}: has no printed board; `palpate rig webcam` makes a rig that has", options.rig);
  if (const auto missing = rig::missing_parts(*rig); !missing.empty())
    return refused("{}: lacks {}; {} --rig {}", options.rig, missing.front().part, missing.front().remedy,
                   options.rig);
  if (const auto possible = desktop::Window::possible(); !possible) return tl::unexpected(possible.error());
  auto pictures = picture_recording(options.record);
  if (!pictures) return tl::unexpected(pictures.error());
  options.play.graphics.record = options.record.file;
  options.play.graphics.record_pictures = std::move(*pictures);
  options.play.program = std::filesystem::read_symlink("/proc/self/exe");
  options.play.rig_file = options.rig;
  auto& graphics = options.play.graphics;
  graphics.rig = *rig;
  graphics.rig_text = read_file(options.rig).value_or("");
  graphics.drivers = drivers();
  graphics.camera = *request;
  graphics.quality = *quality;
  graphics.window = graphics.mouse = true;
  const auto figures = demo::play_at_desk(options.play);
  if (!figures) return tl::unexpected(figures.error());
  if (!options.json.empty()) return write_json(options.json, *figures);
  fmt::print("{} pictures at {:.1f} Hz\n", (*figures)["exchange"]["frames"].get<std::uint64_t>(),
             (*figures)["graphics"]["rate_hz"].get<double>());
  return {};
}

}  // namespace

void add_play(CLI::App& program) {
  auto options = std::make_shared<PlayArguments>();
  auto* command = program.add_subcommand(
      "play", "A game on your desk: a webcam sees a printed board, the mouse holds the stylus");
  command->add_option("--rig", options->rig, "The rig that `palpate rig webcam` wrote, its lens calibrated")
      ->capture_default_str();
  command->add_option("--camera", options->camera, drivers().camera_forms(device::Offer::real))
      ->type_name("CAMERA")
      ->capture_default_str();
  add_camera_options(*command, options->camera_options);
  add_application_option(*command, options->play.application);
  add_settings_options(*command, options->settings, known_applications());
  command->add_option("--seed", options->play.seed, "Seed of the application")->capture_default_str();
  command
      ->add_option("--quality", options->quality,
                   "Of the picture: low, medium, high, or auto: by what is missed")
      ->capture_default_str();
  command
      ->add_option("--monitor", options->monitor,
                   "A second window for those who look on: copy (what the first shows) or outside (the play "
                   "from the side)")
      ->type_name("VIEW");
  command->add_flag("--headset", options->play.graphics.headset,
                    "Show the picture in a headset as well (OpenXR), on whose front the camera sits");
  command->add_flag("--player", options->play.graphics.player, "Let the program play until the mouse moves");
  command
      ->add_option("--seconds", options->play.graphics.seconds,
                   "Stop after this many seconds if nobody has touched mouse or keys; 0 = when the window is "
                   "closed")
      ->check(at_least_zero())
      ->default_val(0.0);
  command->add_option("--out", options->play.graphics.out,
                      "Folder for what was measured frame by frame (realtime_*.csv)");
  add_record_options(*command, options->record);
  command->add_option("--json", options->json, "Write its figures here at the end; - = standard output");
  on(command, [options] { return play(*options); });
}

}  // namespace palpate::tools::commands
