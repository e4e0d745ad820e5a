// What a command takes for an option, in words of ours: in its help, and where something else was written.
#pragma once

#include <CLI/CLI.hpp>
#include <initializer_list>
#include <string>
#include <string_view>
#include <vector>

#include "palpate/core/expected.h"

namespace palpate::tools::commands {

// Numbers from `low` to `high`, both included. Whether it is a number at all is found elsewhere (program.cpp).
CLI::Validator between(double low, double high);
CLI::Validator at_least_zero();
CLI::Validator above_zero();
// One of these words; the one that was meant is named where there is one like it.
CLI::Validator one_of(std::vector<std::string> words);

// Wrong use where one of these options was given: "--stamps: ", then the words.
Expected<void> refuse_given(const CLI::App& command, std::initializer_list<const char*> options,
                            std::string_view words);

}  // namespace palpate::tools::commands
