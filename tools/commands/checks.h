// What a command takes for an option, in words of ours: in its help, and where something else was written.
#pragma once

#include <CLI/CLI.hpp>
#include <string>
#include <vector>

namespace palpate::tools::commands {

// Numbers from `low` to `high`, both included. Whether it is a number at all is found elsewhere (program.cpp).
CLI::Validator between(double low, double high);
CLI::Validator at_least_zero();
CLI::Validator above_zero();
// One of these words; the one that was meant is named where there is one like it.
CLI::Validator one_of(std::vector<std::string> words);

}  // namespace palpate::tools::commands
