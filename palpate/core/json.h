// JSON results. Keys keep the order in which they were written, so that files read like the code that made
// them.
#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>

#include "palpate/core/file.h"

namespace palpate {

using Json = nlohmann::ordered_json;

// Writes indented JSON, whole or not at all; "-" is standard output.
inline Expected<void> write_json(const std::filesystem::path& path, const Json& value) {
  return write_file(path, value.dump(2) + "\n");
}

}  // namespace palpate
