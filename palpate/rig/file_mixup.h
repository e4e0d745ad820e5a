// A rig file where a world file is expected, or the other way round, or no TOML at all: told for what it is,
// with what makes the right one, instead of by the first key that is amiss. Pure functions.
#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "palpate/core/expected.h"
#include "palpate/core/toml.h"

namespace palpate::rig {

// Each is asked of the file before anything else of it is read. Errors: wrong use.
Expected<void> is_no_world_file(const TomlTable& file, const std::string& source);
Expected<void> is_no_rig_file(const TomlTable& file, const std::string& source);

// Of a file that is no TOML and was to be a rig: a table, JSON or the like. None where its form is unknown.
std::optional<Error> file_of_another_form(std::string_view content, const std::string& source);

}  // namespace palpate::rig
