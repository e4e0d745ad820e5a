#include <fmt/format.h>

#include "tools/commands/command.h"
#include "tools/commands/guests.h"

namespace palpate::tools::commands {

void add_apps(CLI::App& program) {
  auto* command = program.add_subcommand("apps", "The applications there are, a line each");
  on(command, []() -> Expected<void> {
    const auto& applications = known_applications();
    if (applications.specs().empty()) notice("this program has no application");
    for (const auto& application : applications.specs()) {
      const auto* from = plugins().origin_of_application(application.name);
      print_line(fmt::format("{:<12}{}{}", application.name, application.summary,
                             from == nullptr ? "" : fmt::format(" (plug-in {})", from->file.string())));
    }
    return {};
  });
}

}  // namespace palpate::tools::commands
