#include "tools/commands/guests.h"

#include <algorithm>
#include <cstdlib>
#include <exception>
#include <filesystem>

#include "palpate/core/text.h"
#include "tools/commands/built_in_applications.h"
#include "tools/commands/command.h"

namespace palpate::tools::commands {
namespace {

namespace fs = std::filesystem;

struct Known {
  plugin::Guests guests;
  plugin::Report plugins;
};
Known& known() {
  static Known all;
  return all;
}

// Beside the libraries of the installation that this program is of.
fs::path system_folder() {
  std::error_code none;
  const fs::path program = fs::read_symlink("/proc/self/exe", none);
  return (program.parent_path() / PALPATE_PLUGINS_FROM_PROGRAM).lexically_normal();
}

// For the programs that this one starts: the files come first in the path they look along.
void hand_on(const std::vector<std::string>& files) {
  if (files.empty()) return;
  std::string path;
  std::error_code none;
  for (const auto& file : files) path += fs::canonical(file, none).string() + ':';
  if (const char* before = std::getenv("PALPATE_PLUGIN_PATH")) path += before;
  setenv("PALPATE_PLUGIN_PATH", path.c_str(), 1);
}

Expected<void> add_own(const std::function<void(plugin::Guests&)>& own, plugin::Guests& guests) {
  if (!own) return {};
  try {
    own(guests);
  } catch (const std::exception& thrown) {
    return refused("{}", excerpt(thrown.what(), 400));
  }
  return {};
}

}  // namespace

const scene::ApplicationRegistry& known_applications() { return known().guests.applications; }
const device::DriverRegistry& drivers() { return known().guests.drivers; }
const plugin::Report& plugins() { return known().plugins; }

Expected<void> gather_guests(const std::function<void(plugin::Guests&)>& own,
                             const std::vector<std::string>& files) {
  Known& all = known();
  all.guests = {built_in_applications(), built_in_drivers()};
  all.plugins = {};
  if (auto added = add_own(own, all.guests); !added) return added;
  const bool privileged = plugin::has_rights_of_its_own();
  if (privileged && !files.empty())
    return refused(
        "--plugin {}: this program has rights of its own and takes plug-ins from {} alone; put it there",
        excerpt(files.front(), 400), system_folder().string());
  for (const auto& file : files)
    if (auto loaded = plugin::load(file, all.guests, all.plugins); !loaded) return loaded;
  auto path = plugin::search_path(system_folder());
  if (privileged) path.folders = {system_folder()};
  plugin::load_all(path, all.guests, all.plugins);
  for (const auto& line : all.plugins.skipped) notice("left out: " + line);
  hand_on(files);
  return {};
}

}  // namespace palpate::tools::commands
