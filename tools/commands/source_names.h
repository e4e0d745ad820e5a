// What people are told of a table that came out of a recording and lies in a file of its own meanwhile: "s.mcap: table pivot".
//
// Process-wide; the main thread's alone.
#pragma once

#include <string>

#include "palpate/core/json.h"

namespace palpate::tools::commands {

void name_source(const std::string& file, std::string name);
// With each such file called by its name.
std::string with_sources_named(std::string text);
void with_sources_named(Json& json);

}  // namespace palpate::tools::commands
