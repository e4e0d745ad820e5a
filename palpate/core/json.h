// JSON results. Keys keep the order in which they were written, so that files read like the code that made
// them.
#pragma once

#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>

#include "palpate/core/file.h"
#include "palpate/core/text.h"

namespace palpate::inline core {

using Json = nlohmann::ordered_json;

// Whether a plain file is there whose first character says that it is something else.
inline bool holds_no_json(const std::filesystem::path& path) {
  std::error_code failed;
  if (!std::filesystem::is_regular_file(path, failed)) return false;
  std::ifstream file(path);
  char first = 0;
  return file >> first && first != '{' && first != '[';
}

// Writes indented JSON, whole or not at all; "-" is standard output. Bytes that are no UTF-8 (labels of
// people's tables) are written as U+FFFD, characters that steer a terminal as \uXXXX.
// A file that is there and holds something else (a table, say, whose name slipped in) is not replaced: wrong use.
inline Expected<void> write_json(const std::filesystem::path& path, const Json& value) {
  if (path != "-" && holds_no_json(path))
    return wrong_use("{}: exists already and holds no JSON; name another file for the result", path.string());
  return write_file(path, escaped_json(value.dump(2, ' ', false, Json::error_handler_t::replace)) + "\n");
}

}  // namespace palpate::inline core
