#include <fmt/format.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>

#include "palpate/desktop/window.h"
#include "palpate/headset/headset.h"
#include "tools/commands/build_info.h"
#include "tools/commands/checks.h"
#include "tools/commands/command.h"
#include "tools/commands/guests.h"
#include "tools/commands/record_options.h"
#include "tools/commands/settings_options.h"
#include "tools/demo/demo.h"

namespace palpate::tools::commands {
namespace {

struct DemoArguments {
  demo::DemoOptions demo;
  SettingsOptions settings;
  RecordOptions record;
  std::string world, quality = "auto", monitor;
  bool stereo = false, headless = false, two_hosts = false, insecure = false;
  bool seconds_said = false;
};

void add_play_options(CLI::App& command, DemoArguments& options) {
  add_application_option(command, options.demo.application);
  command.add_option("--seconds", options.demo.seconds, "Length of the play in lock-step")
      ->default_val(30.0)
      ->check(between(1.0, 3600.0));
  command
      .add_option("--seed", options.demo.seed,
                  "Draws the laboratory's imperfections, noise, serves and player")
      ->default_val(1);
  add_settings_options(command, options.settings, known_applications());
  command.add_option("--world", options.world, "World file; the reference laboratory where none is named");
  command.add_option("--out", options.demo.out, "Folder for report, summary, pictures, video and raw data")
      ->default_val("./palpate-report");
  command.add_flag("--quick", options.demo.quick,
                   "A shorter play, under 30 s on an idle machine without a window; too short to judge the "
                   "share of returned "
                   "serves");
}

void add_picture_options(CLI::App& command, DemoArguments& options) {
  command
      .add_option("--quality", options.quality,
                  "Of the pictures: low, medium, high, or auto: by what is missed (in lock-step medium)")
      ->capture_default_str();
  command.add_flag("--stereo", options.stereo,
                   "Two cameras on the head, and a picture for each eye: side by side");
  command.add_flag("--headless", options.headless, "No window, where there is a display too");
  command
      .add_option("--monitor", options.monitor,
                  "Beside the window a second one for those who look on: copy (what the first shows) or "
                  "outside (the play from the side)")
      ->type_name("VIEW");
  command.add_flag(
      "--headset", options.demo.headset,
      "Show the real-time run's pictures in a headset (OpenXR), beside the window or without one");
}

void add_network_options(CLI::App& command, DemoArguments& options) {
  auto* two_hosts = command.add_flag(
      "--two-hosts", options.two_hosts,
      "Do the real-time run across two hosts (network namespaces; needs root, or `unshare "
      "--map-current-user --keep-caps` in front), encrypted, and pull the cable between them for 3 s in its "
      "middle");
  command
      .add_flag("--insecure", options.insecure,
                "With --two-hosts: without keys, to see what encryption hides")
      ->needs(two_hosts);
}

Expected<void> choose_pictures(DemoArguments& options) {
  const auto quality = render::parse_quality_choice(options.quality);
  if (!quality) return tl::unexpected(quality.error());
  options.demo.quality = *quality;
  if (options.demo.headset) {  // known now, not after the calibration
    if (options.two_hosts)
      return wrong_use("--headset: --two-hosts plays without anybody at it; leave one of them out");
    if (auto found = headset::Headset::look_for(); !found) return tl::unexpected(found.error());
  }
  if (options.monitor.empty()) return {};
  const auto view = desktop::parse_monitor_view(options.monitor);
  if (!view) return tl::unexpected(view.error());
  if (options.headless || options.two_hosts)
    return wrong_use("--monitor {}: stands beside the window, which {} does without; leave one of them out",
                     options.monitor, options.headless ? "--headless" : "--two-hosts");
  options.demo.monitor = *view;
  return {};
}

Expected<void> choose_world(DemoArguments& options) {
  auto& demo = options.demo;
  auto world = world_of(options.world, demo.applications);
  if (!world) return tl::unexpected(world.error());
  demo.world = std::move(*world);
  if (options.stereo) demo.world.camera.count = 2;
  return apply(options.settings, demo.applications, demo.application, demo.world.settings);
}

constexpr double kMostQuickPictures = 110.0;
constexpr double kToFindTheMouse_s = 10.0;  // a person reads what the window says first

void choose_length(DemoArguments& options) {
  auto& demo = options.demo;
  const auto* spec = demo.applications.find(demo.application);
  const double asked_for = spec == nullptr ? 0.0 : demo.quick ? spec->quick_demo_s : spec->demo_s;
  if (demo.quick) demo.realtime_s = 3.0;
  if (!options.seconds_said && demo.quick) demo.seconds = 4.0;
  if (!options.seconds_said && asked_for > 0.0) demo.seconds = asked_for;
  if (!options.seconds_said && demo.quick && spec != nullptr && spec->shorten_for_a_quick_demo)
    spec->shorten_for_a_quick_demo(demo.world.settings);
  // Where a quick demo plays longer for something to happen. Who names the length gets every picture: players see by them.
  if (!options.seconds_said && demo.quick) demo.most_pictures = kMostQuickPictures;
  if (!options.two_hosts) return;
  demo.two_hosts = demo::TwoHostsOptions{.insecure = options.insecure};
  demo.realtime_s = std::max(demo.realtime_s, 15.0);
}

// What gives the same report again.
std::string command_line(const DemoArguments& options) {
  const auto& demo = options.demo;
  std::string line = "palpate demo";
  if (const auto* from = plugins().origin_of_application(demo.application))
    line += " --plugin " + from->file.string();
  if (demo.application != default_application(demo.applications)) line += " --app " + demo.application;
  if (demo.quality) line += " --quality " + options.quality;
  if (!options.world.empty()) line += " --world " + options.world;
  if (options.stereo) line += " --stereo";
  line += typed(options.settings);
  line += fmt::format(" --seed {}", demo.seed);
  if (demo.quick) line += " --quick";
  if (options.two_hosts) line += options.insecure ? " --two-hosts --insecure" : " --two-hosts";
  if (options.seconds_said) line += fmt::format(" --seconds {:g}", demo.seconds);
  return line;
}

Expected<void> show_demo(DemoArguments& options) {
  auto& demo = options.demo;
  demo.applications = known_applications();
  if (auto known = check_application(demo.applications, demo.application); !known) return known;
  if (const auto* spec = demo.applications.find(demo.application); !spec->make_player)
    return wrong_use(
        "--app {}: has no scripted player (make_player in its specification), which the demo needs; play it "
        "yourself: palpate physics, and palpate graphics --window --mouse",
        demo.application);
  if (auto chosen = choose_pictures(options); !chosen) return chosen;
  if (auto chosen = choose_world(options); !chosen) return chosen;
  choose_length(options);
  if (const auto pictures = picture_recording(options.record); !pictures)
    return tl::unexpected(pictures.error());
  demo.record = options.record.file;
  if (options.record.pictures != "none") demo.recorded_pictures = options.record.pictures;
  demo.command = command_line(options);
  demo.build = build_info();
  std::error_code ignored;
  demo.program = std::filesystem::read_symlink("/proc/self/exe", ignored);
  const bool display = std::getenv("DISPLAY") != nullptr && *std::getenv("DISPLAY") != '\0';
  if (display && !options.headless && !options.two_hosts) {
    const auto possible = desktop::Window::possible();
    demo.window = possible.has_value();
    if (demo.window) demo.realtime_s = std::max(demo.realtime_s, kToFindTheMouse_s);
    if (!possible) notice(possible.error().message + "; the demo goes on without");
  }
  const auto done = demo::run_demo(demo);
  if (!done) return tl::unexpected(done.error());
  for (const auto& line : done->in_words) print_line(line);
  return {};
}

}  // namespace

void add_demo(CLI::App& program) {
  auto* command = program.add_subcommand(
      "demo", "Calibrate a simulated rig, play on it in lock-step and in real time, write a report");
  auto options = std::make_shared<DemoArguments>();
  add_play_options(*command, *options);
  add_picture_options(*command, *options);
  add_network_options(*command, *options);
  add_record_options(*command, options->record);
  on(command, [options, command] {
    options->seconds_said = command->count("--seconds") > 0;
    return show_demo(*options);
  });
}

}  // namespace palpate::tools::commands
