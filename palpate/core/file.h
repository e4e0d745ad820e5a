// Files that are written whole or not at all, and read with an error a person can act on.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>

#include "palpate/core/expected.h"

namespace palpate::inline core {

// The most bytes that a file of each kind may hold: far more than any of ours do, and no more than a machine
// has room for.
inline constexpr std::size_t kMostSettingsBytes = 4'000'000;   // rigs, worlds, boards, arm models
inline constexpr std::size_t kMostTableBytes = 512'000'000;    // tables, recordings
inline constexpr std::size_t kMostPictureBytes = 256'000'000;  // as stored
inline constexpr std::size_t kMostMeshBytes = 1'000'000'000;

// The whole file as bytes. Wrong use when it is missing, unreadable, larger than `most`, or anything but a
// plain file: a pipe or a device could keep its reader waiting or never end. Refused when it changes
// meanwhile.
Expected<std::string> read_file(const std::filesystem::path& path, std::size_t most = kMostTableBytes);

// Whether there is something of this name; not where nobody can tell, as with links in a circle.
bool is_there(const std::filesystem::path& path);
// Whether both names lead to one file, whether it is there yet or not.
bool same_file(const std::filesystem::path& a, const std::filesystem::path& b);

enum class FileMode : unsigned { all = 0644, own = 0600 };  // who may read it

// Writes to a temporary neighbour, syncs, then renames over `path`: a full disk or a crash leaves the old
// file. What a writer that was killed has left goes when `path` is written again.
// "-" writes to standard output. Missing parent folders are an error (wrong use), and so is a pipe that nobody
// reads within a second; for a reader that stops reading it waits until the program is told to stop.
Expected<void> write_file(const std::filesystem::path& path, std::string_view content,
                          FileMode mode = FileMode::all);

// Creates a folder and its parents.
Expected<void> make_folder(const std::filesystem::path& path);

// 64-bit FNV-1a hash of bytes as 16 hex digits: provenance of the data a calibration came from, not security.
std::string content_hash(std::string_view content);

}  // namespace palpate::inline core
