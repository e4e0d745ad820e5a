#include <fmt/format.h>

#include "tools/commands/command.h"
#include "tools/commands/guests.h"

namespace palpate::tools::commands {

void add_apps(CLI::App& program) {
  auto* command = program.add_subcommand("apps", "The applications there are, a line each");
  on(command, []() -> Expected<void> {
    for (const auto& application : known_applications().specs()) {
      const auto* from = plugins().origin_of_application(application.name);
      fmt::print("{:<12}{}{}\n", application.name, application.summary,
                 from == nullptr ? "" : fmt::format(" (plug-in {})", from->file.string()));
    }
    return {};
  });
}

}  // namespace palpate::tools::commands
