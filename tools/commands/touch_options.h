// Options of `physics` and `demo` that say what touch lets one explore; they go over the world file's
// [touch].
#pragma once

#include <string>

#include "palpate/sim/config/world_file.h"
#include "tools/commands/command.h"

namespace palpate::tools::commands {

struct TouchOptions {
  std::string mesh, unit, material;
};

// Materials by name: N/m, N s/m and friction; docs/guides/touch.md says where the numbers come from.
void add_touch_options(CLI::App& command, TouchOptions& options);

// Puts what was given over `world`. Wrong use where --unit stands alone, or the application is another.
Expected<void> apply(const TouchOptions& options, const std::string& application,
                     sim::config::WorldFile& world);

// The options again, for a report's command line; empty where none was given.
std::string typed(const TouchOptions& options);

}  // namespace palpate::tools::commands
