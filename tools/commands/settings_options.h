// How commands let a person choose an application and its settings: --app, --world, --settings, and the options
// that the applications bring (scene::ApplicationOption).
//
// Later goes over earlier: the reference, the world file, the file of settings, the options.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "palpate/scene/application_registry.h"
#include "palpate/sim/config/world_file.h"
#include "tools/commands/command.h"

namespace palpate::tools::commands {

struct SettingsOptions {
  std::string settings;                     // file
  std::vector<std::string> names;           // of the applications' options, in their order
  std::map<std::string, std::string> said;  // by name; empty: nothing was said
};

// --app; the program's first application where none is named.
CLI::Option* add_application_option(CLI::App& command, std::string& application);
// Empty where the program has none.
std::string default_application(const scene::ApplicationRegistry& applications);
// Wrong use for a name that is not known, and where the program has no application.
Expected<void> check_application(const scene::ApplicationRegistry& applications, const std::string& name);

// --settings, and every option that an application brings. Throws std::invalid_argument, which names the
// application, for one whose name the command has already.
void add_settings_options(CLI::App& command, SettingsOptions& options,
                          const scene::ApplicationRegistry& applications);

// Puts what was said over `values`. Wrong use for an option that `application` does not have.
Expected<void> apply(const SettingsOptions& options, const scene::ApplicationRegistry& applications,
                     const std::string& application, scene::SettingValues& values);

// The options again, for a report's command line; empty where none was given.
std::string typed(const SettingsOptions& options);

// The world of a file; the reference world where none is named.
Expected<sim::config::WorldFile> world_of(const std::string& file,
                                          const scene::ApplicationRegistry& applications);

}  // namespace palpate::tools::commands
