// What `palpate COMMAND --help` looks like: options with what they take in words a person uses, lines that fit a
// terminal, and an example below.
#pragma once

#include <CLI/CLI.hpp>

namespace palpate::tools::commands {

// For the program and every command below it; called once they are all there.
void describe_help(CLI::App& program);

}  // namespace palpate::tools::commands
