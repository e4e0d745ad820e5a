// The program around its commands: parses, runs the action of the command chosen, turns its error into one
// line and the exit code.
#pragma once

#include <functional>

#include "tools/commands/command.h"

namespace palpate::tools::commands {

// main()'s result. `add_commands` says which commands there are.
int run_program(const std::function<void(CLI::App&)>& add_commands, int argc, char** argv);

}  // namespace palpate::tools::commands
