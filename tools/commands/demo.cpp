#include <fmt/format.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>

#include "palpate/desktop/window.h"
#include "tools/commands/command.h"
#include "tools/commands/guests.h"
#include "tools/commands/touch_options.h"
#include "tools/demo/demo.h"

namespace palpate::tools::commands {

void add_demo(CLI::App& program) {
  auto* command = program.add_subcommand(
      "demo", "Calibrate a simulated rig, play on it in lock-step and in real time, write a report");
  struct Options {
    demo::DemoOptions demo;
    TouchOptions touch;
    std::string world, quality = "medium", monitor;
    bool stereo = false, headless = false, two_hosts = false, insecure = false;
  };
  auto options = std::make_shared<Options>();
  command->add_option("--app", options->demo.application, "Application; `palpate apps` lists them")
      ->default_val("pingpong");
  command->add_option("--seconds", options->demo.seconds, "Length of the play in lock-step")
      ->default_val(30.0)
      ->check(CLI::Range(1.0, 3600.0));
  command
      ->add_option("--seed", options->demo.seed,
                   "Draws the laboratory's imperfections, noise, serves and player")
      ->default_val(1);
  add_touch_options(*command, options->touch);
  command->add_option("--world", options->world, "World file; the reference laboratory where none is named");
  command->add_option("--out", options->demo.out, "Folder for report, summary, pictures, video and raw data")
      ->default_val("./palpate-report");
  command->add_option("--quality", options->quality, "Of the pictures: low, medium or high")
      ->capture_default_str();
  command->add_flag("--stereo", options->stereo,
                    "Two cameras on the head, and a picture for each eye: side by side");
  command->add_flag("--headless", options->headless, "No window, where there is a display too");
  command
      ->add_option("--monitor", options->monitor,
                   "Beside the window a second one for those who look on: copy (what the first shows) or "
                   "outside (the play from the side)")
      ->type_name("VIEW");
  auto* two_hosts = command->add_flag(
      "--two-hosts", options->two_hosts,
      "Play the real-time leg across two hosts (network namespaces; needs root, or `unshare "
      "--map-current-user --keep-caps` in front), encrypted, and pull the cable between them for 3 s in its "
      "middle");
  command
      ->add_flag("--insecure", options->insecure,
                 "With --two-hosts: without keys, to see what encryption hides")
      ->needs(two_hosts);
  auto* quick = command->add_flag(
      "--quick", options->demo.quick,
      "A shorter play, under 30 s on an idle machine; too short to judge the share of returned serves");
  auto* seconds = command->get_option("--seconds");
  on(command, [options, quick, seconds]() -> Expected<void> {
    auto& demo = options->demo;
    demo.applications = known_applications();
    if (demo.applications.find(demo.application) == nullptr)
      return wrong_use("--app {}: not known; `palpate apps` lists the applications there are",
                       demo.application);
    const auto quality = render::parse_quality(options->quality);
    if (!quality) return tl::unexpected(quality.error());
    demo.quality = *quality;
    if (!options->monitor.empty()) {
      const auto view = desktop::parse_monitor_view(options->monitor);
      if (!view) return tl::unexpected(view.error());
      if (options->headless || options->two_hosts)
        return wrong_use(
            "--monitor {}: stands beside the window, which {} does without; leave one of them out",
            options->monitor, options->headless ? "--headless" : "--two-hosts");
      demo.monitor = *view;
    }
    demo.world = sim::config::reference_world();
    demo.command = "palpate demo";
    if (const auto* from = plugins().origin_of_application(demo.application))
      demo.command += " --plugin " + from->file.string();
    if (demo.application != "pingpong") demo.command += " --app " + demo.application;
    if (demo.quality != render::Quality::medium) demo.command += " --quality " + options->quality;
    if (!options->world.empty()) {
      auto world = sim::config::read_world(options->world);
      if (!world) return tl::unexpected(world.error());
      demo.world = *world;
      demo.command += " --world " + options->world;
    }
    if (options->stereo) {
      demo.world.camera.count = 2;
      demo.command += " --stereo";
    }
    if (auto ok = apply(options->touch, demo.application, demo.world); !ok) return ok;
    demo.command += typed(options->touch);
    demo.command += fmt::format(" --seed {}", demo.seed);
    if (quick->count() > 0) {
      if (seconds->count() == 0) demo.seconds = 4.0;
      demo.realtime_s = 3.0;
      demo.command += " --quick";
    }
    if (options->two_hosts) {
      demo.two_hosts = demo::TwoHostsOptions{.insecure = options->insecure};
      demo.realtime_s = std::max(demo.realtime_s, 15.0);
      demo.command += options->insecure ? " --two-hosts --insecure" : " --two-hosts";
    }
    if (seconds->count() > 0) demo.command += fmt::format(" --seconds {:g}", demo.seconds);
    std::error_code ignored;
    demo.program = std::filesystem::read_symlink("/proc/self/exe", ignored);
    demo.notice = notice;
    const bool display = std::getenv("DISPLAY") != nullptr && *std::getenv("DISPLAY") != '\0';
    if (display && !options->headless && !options->two_hosts) {
      const auto possible = desktop::Window::possible();
      demo.window = possible.has_value();
      if (!possible) notice(possible.error().message + "; the demo goes on without");
    }
    const auto done = demo::run_demo(demo);
    if (!done) return tl::unexpected(done.error());
    for (const auto& line : done->in_words) fmt::print("{}\n", line);
    return {};
  });
}

}  // namespace palpate::tools::commands
