// JSON results. Keys keep the order in which they were written, so that files read like the code that made
// them.
#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>

#include "palpate/core/file.h"
#include "palpate/core/text.h"

namespace palpate::inline core {

using Json = nlohmann::ordered_json;

// Writes indented JSON, whole or not at all; "-" is standard output. Bytes that are no UTF-8 (labels of
// people's tables) are written as U+FFFD, characters that steer a terminal as \uXXXX.
inline Expected<void> write_json(const std::filesystem::path& path, const Json& value) {
  return write_file(path, escaped_json(value.dump(2, ' ', false, Json::error_handler_t::replace)) + "\n");
}

}  // namespace palpate::inline core
