#include <fmt/format.h>

#include "tools/commands/built_in_applications.h"
#include "tools/commands/command.h"

namespace palpate::tools::commands {

void add_apps(CLI::App& program) {
  auto* command = program.add_subcommand("apps", "The applications there are, a line each");
  on(command, []() -> Expected<void> {
    const scene::ApplicationRegistry applications = built_in_applications();
    if (applications.specs().empty()) notice("this program has no application");
    for (const auto& application : applications.specs())
      fmt::print("{:<12}{}\n", application.name, application.summary);
    return {};
  });
}

}  // namespace palpate::tools::commands
