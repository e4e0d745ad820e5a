#include "tools/commands/settings_options.h"

#include <fmt/format.h>

#include <algorithm>
#include <stdexcept>

#include "palpate/core/nearest.h"
#include "palpate/core/text.h"
#include "palpate/scene/settings_file.h"
#include "tools/commands/guests.h"

namespace palpate::tools::commands {
namespace {

const scene::ApplicationOption* option_of(const scene::ApplicationSpec& application,
                                          const std::string& name) {
  const auto at = std::find_if(application.options.begin(), application.options.end(),
                               [&](const auto& option) { return option.name == name; });
  return at == application.options.end() ? nullptr : &*at;
}

// The applications that have the option, as a person names them: "touch or cloth".
std::string owners_of(const scene::ApplicationRegistry& applications, const std::string& name) {
  std::vector<std::string> owners;
  for (const auto& application : applications.specs())
    if (option_of(application, name) != nullptr) owners.push_back(application.name);
  return fmt::format("{}", fmt::join(owners, " or "));
}

}  // namespace

std::string default_application(const scene::ApplicationRegistry& applications) {
  return applications.specs().empty() ? std::string() : applications.specs().front().name;
}

CLI::Option* add_application_option(CLI::App& command, std::string& application) {
  return command
      .add_option("--app", application, "Application to run; `palpate apps` lists the ones there are")
      ->default_val(default_application(known_applications()))
      ->type_name(known_applications().specs().empty()
                      ? "NAME"
                      : fmt::format("{}", fmt::join(known_applications().names(), "|")));
}

Expected<void> check_application(const scene::ApplicationRegistry& applications, const std::string& name) {
  if (applications.specs().empty())
    return wrong_use(
        "--app {}: this program has no application; build one into it (cmake/layers.cmake lists them)",
        excerpt(name));
  if (applications.find(name) == nullptr) {
    const auto meant = nearest(name, applications.names());
    return meant.empty() ? wrong_use(
                               "--app {}: not known; `palpate apps` lists the applications there are, "
                               "--plugin FILE adds one",
                               excerpt(name))
                         : wrong_use("--app {}: not known; did you mean {}?", excerpt(name), meant);
  }
  return {};
}

void add_settings_options(CLI::App& command, SettingsOptions& options,
                          const scene::ApplicationRegistry& applications) {
  command.add_option("--settings", options.settings,
                     "File of the application's settings, which go over those of the world file");
  for (const auto& application : applications.specs())
    for (const auto& option : application.options) {
      if (options.said.contains(option.name)) continue;
      if (command.get_option_no_throw(option.name) != nullptr)
        throw std::invalid_argument(
            fmt::format("application '{}': its option {} has the name of one of `palpate {}`; choose another",
                        application.name, option.name, command.get_name()));
      options.names.push_back(option.name);
      command.add_option(option.name, options.said[option.name],
                         fmt::format("With --app {}: {}", owners_of(applications, option.name), option.help));
    }
}

Expected<void> apply(const SettingsOptions& options, const scene::ApplicationRegistry& applications,
                     const std::string& application, scene::SettingValues& values) {
  if (auto fine = check_application(applications, application); !fine) return fine;
  if (!options.settings.empty())
    if (auto read = scene::read_settings_file(options.settings, applications, values); !read) return read;
  const scene::ApplicationSpec& running = *applications.find(application);
  for (const auto& name : options.names) {
    const std::string& said = options.said.at(name);
    if (said.empty()) continue;
    const auto* option = option_of(running, name);
    if (option == nullptr)
      return wrong_use("{} {}: {} has no such option; --app {} has", name, excerpt(said), application,
                       owners_of(applications, name));
    const auto& choices = option->choices;
    if (!choices.empty() && std::find(choices.begin(), choices.end(), said) == choices.end())
      return wrong_use("{} {}: {} is expected", name, excerpt(said), fmt::join(choices, " or "));
    if (auto applied = option->apply(said, values); !applied) return applied;
  }
  return {};
}

std::string typed(const SettingsOptions& options) {
  std::string line;
  if (!options.settings.empty()) line += " --settings " + options.settings;
  for (const auto& name : options.names)
    if (!options.said.at(name).empty()) line += fmt::format(" {} {}", name, options.said.at(name));
  return line;
}

Expected<sim::config::WorldFile> world_of(const std::string& file,
                                          const scene::ApplicationRegistry& applications) {
  if (file.empty()) return sim::config::parse_world("", "reference world", applications);
  return sim::config::read_world(file, applications);
}

}  // namespace palpate::tools::commands
