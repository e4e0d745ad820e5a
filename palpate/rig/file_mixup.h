// A rig file where a world file is expected, or the other way round: told for what it is, with what makes the
// right one, instead of by the first key that is amiss. Pure functions.
#pragma once

#include <string>

#include "palpate/core/expected.h"
#include "palpate/core/toml.h"

namespace palpate::rig {

// Each is asked of the file before anything else of it is read. Errors: wrong use.
Expected<void> is_no_world_file(const TomlTable& file, const std::string& source);
Expected<void> is_no_rig_file(const TomlTable& file, const std::string& source);

}  // namespace palpate::rig
