#include <algorithm>
#include <cerrno>
#include <cmath>
#include <csignal>
#include <cstdio>
#include <cstring>
#include <exception>

#include "apps/palpate/command.h"
#include "palpate/core/text.h"

namespace palpate::app {
namespace {
Action chosen;
}
void set_action(Action action) { chosen = std::move(action); }

namespace {
// "nan" and "inf" pass as numbers, and a comparison with a range lets the former through.
Expected<void> numbers_in_range(const CLI::App& command) {
  for (const auto* option : command.get_options()) {
    const std::string type = option->get_type_name();  // with its range, where it has one
    if (type.starts_with("UINT")) {                    // a sign or too many digits would wrap round
      for (const auto& text : option->results())
        if (text.starts_with('-') || text.size() > 19)
          return wrong_use("{}: is '{}', a whole number from 0 to 1e19 is expected; see --help",
                           option->get_name(), text);
      continue;
    }
    if (!type.starts_with("FLOAT") && type.find(',') == std::string::npos) continue;
    for (const auto& text : option->results()) {
      double value = 0.0;
      if (CLI::detail::lexical_cast(text, value) && !std::isfinite(value))
        return wrong_use("{}: is '{}', a finite number is expected; see --help", option->get_name(), text);
    }
  }
  for (const auto* chosen_command : command.get_subcommands())
    if (auto fine = numbers_in_range(*chosen_command); !fine) return fine;
  return {};
}

// A word where a command is expected that is none, or an option there that is none: named. Else empty.
std::string unknown_command(const CLI::App& program, int argc, char** argv) {
  const CLI::App* command = &program;
  for (int i = 1; i < argc && command->get_require_subcommand_min() > 0; ++i) {
    const std::string word = argv[i];
    if (word.starts_with('-'))
      return command->get_option_no_throw(word.substr(0, word.find('='))) != nullptr
                 ? ""
                 : fmt::format("{}: no such option of '{}', which expects a command", excerpt(word),
                               command->get_name());
    const auto known = command->get_subcommands([](const CLI::App*) { return true; });
    const auto at = std::find_if(known.begin(), known.end(),
                                 [&](const CLI::App* other) { return other->check_name(word); });
    if (at == known.end()) {
      std::string names;
      for (const auto* other : known) names += (names.empty() ? "" : ", ") + other->get_name();
      return fmt::format("{}: no such command; one of {} is expected", excerpt(word), names);
    }
    command = *at;
  }
  return "";
}

// What was printed may still be on its way: that the disk behind it is full shows only now.
int after_printing() {
  if (std::fflush(stdout) == 0 && std::ferror(stdout) == 0) return 0;
  std::fprintf(stderr, "palpate: standard output: writing failed (%s); free some space and try again\n",
               std::strerror(errno));
  return 1;
}
}  // namespace
}  // namespace palpate::app

int main(int argc, char** argv) {
  using namespace palpate;
  // A file that may not grow further is then an error of write(), not the end of the program.
  std::signal(SIGXFSZ, SIG_IGN);
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
  app::add_calibrate_landmarks(*calibrate);
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
  app::add_keys(program);
  app::add_tracker(program);
  try {
    program.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    if (error.get_exit_code() == 0) {
      program.exit(error);
      return app::after_printing();
    }
    const auto unknown = app::unknown_command(program, argc, argv);
    std::fprintf(stderr, "palpate: %s; see --help\n", unknown.empty() ? error.what() : unknown.c_str());
    return 2;
  }
  try {
    auto done = app::numbers_in_range(program);
    if (done) done = app::chosen();
    if (done) return app::after_printing();
    std::fprintf(stderr, "palpate: %s\n", excerpt(done.error().message, 8192).c_str());
    return done.error().exit_code();
  } catch (const std::exception& error) {
    std::fprintf(stderr, "palpate: %s\n", excerpt(error.what(), 8192).c_str());
    return 1;
  }
}
