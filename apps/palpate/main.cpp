#include <cstdio>
#include <exception>

#include "apps/palpate/command.h"

namespace palpate::app {
namespace {
Action chosen;
}
void set_action(Action action) { chosen = std::move(action); }
}  // namespace palpate::app

int main(int argc, char** argv) {
  using namespace palpate;
  CLI::App program("palpate - high-precision augmented-reality haptics", "palpate");
  program.require_subcommand(1);
  program.set_version_flag("--version", PALPATE_VERSION);
  auto* calibrate =
      program.add_subcommand("calibrate", "Calibrate arm, tracker, camera and surfaces to each other");
  calibrate->require_subcommand(1);
  app::add_calibrate_pivot(*calibrate);
  app::add_calibrate_points(*calibrate);
  app::add_calibrate_arm(*calibrate);
  app::add_calibrate_surface(*calibrate);
  app::add_calibrate_camera(*calibrate);
  app::add_calibrate_hand_eye(*calibrate);
  app::add_calibrate_all(*calibrate);
  app::add_demo(program);
  app::add_apps(program);
  app::add_world(program);
  app::add_rig(program);
  app::add_study(program);
  app::add_physics(program);
  app::add_graphics(program);
  try {
    program.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    if (error.get_exit_code() == 0) return program.exit(error);
    std::fprintf(stderr, "palpate: %s; see --help\n", error.what());
    return 2;
  }
  try {
    const auto done = app::chosen();
    if (done) return 0;
    std::fprintf(stderr, "palpate: %s\n", done.error().message.c_str());
    return done.error().exit_code();
  } catch (const std::exception& error) {
    std::fprintf(stderr, "palpate: %s\n", error.what());
    return 1;
  }
}
