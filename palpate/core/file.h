// Files that are written whole or not at all, and read with an error a person can act on.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>

#include "palpate/core/expected.h"

namespace palpate::inline core {

// The whole file as bytes. Wrong use when it is missing, a folder or unreadable.
Expected<std::string> read_file(const std::filesystem::path& path);

enum class FileMode : unsigned { all = 0644, own = 0600 };  // who may read it

// Writes to a temporary neighbour, syncs, then renames over `path`: a full disk or a crash leaves the old
// file.
// "-" writes to standard output. Missing parent folders are an error (wrong use).
Expected<void> write_file(const std::filesystem::path& path, std::string_view content,
                          FileMode mode = FileMode::all);

// Creates a folder and its parents.
Expected<void> make_folder(const std::filesystem::path& path);

// 64-bit FNV-1a hash of bytes as 16 hex digits: provenance of the data a calibration came from, not security.
std::string content_hash(std::string_view content);

}  // namespace palpate::inline core
