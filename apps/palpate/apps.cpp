#include <fmt/format.h>

#include "apps/palpate/command.h"
#include "palpate/applications/applications.h"

namespace palpate::app {

void add_apps(CLI::App& program) {
  auto* command = program.add_subcommand("apps", "The applications there are, a line each");
  on(command, []() -> Expected<void> {
    for (const auto& application : applications())
      fmt::print("{:<12}{}\n", application.name, application.summary);
    return {};
  });
}

}  // namespace palpate::app
