// A look at a TOML file before the library parses it. The library keeps a table in a table for each part of a
// dotted key and takes them down one in the other, which ends the process where they are tens of thousands
// deep; and it searches lists of all tables there are for each further one.
#pragma once

#include <string>
#include <string_view>

#include "palpate/core/expected.h"

namespace palpate::inline core {

// Wrong use with file and line where a text is no settings file by its size, by the depth of its keys and
// values, by the number of its tables, or by a zero byte. What is no TOML for other reasons passes: the parser
// says that better.
Expected<void> check_toml(std::string_view content, const std::string& source);

}  // namespace palpate::inline core
