// The kinds of `palpate sample`, a subcommand each.
#pragma once

#include <CLI/CLI.hpp>

namespace palpate::tools::commands {

void add_sample_arm(CLI::App& sample);
void add_sample_touches(CLI::App& sample);
void add_sample_board(CLI::App& sample);
void add_sample_pivot(CLI::App& sample);
void add_sample_tools(CLI::App& sample);

}  // namespace palpate::tools::commands
