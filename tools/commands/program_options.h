// Options of the program as a whole, before or after the command: taken out of the command line before any command is
// declared, as what they bring is in the help and their lines come first.
#pragma once

#include <CLI/CLI.hpp>
#include <string>
#include <vector>

#include "palpate/core/expected.h"

namespace palpate::tools::commands {

struct ProgramOptions {
  std::vector<std::string> plugins;  // --plugin FILE, as often as there are some
  std::string log;                   // --log FILE; empty: the variable PALPATE_LOG, or none
};

// Takes them out of `words`, up to a "--"; wrong use: one without a file.
Expected<ProgramOptions> take_program_options(std::vector<std::string>& words);

// Lines of the log go to standard error, and to the file where there is one. Programs that this one starts add theirs to
// the same file.
Expected<void> open_log(const ProgramOptions& options);

// For the help.
void describe_program_options(CLI::App& program);

}  // namespace palpate::tools::commands
