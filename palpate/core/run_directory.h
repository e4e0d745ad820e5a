// A folder for sockets and shared memory that belongs to this user alone.
#pragma once

#include <filesystem>

#include "palpate/core/expected.h"

namespace palpate::inline core {

// $XDG_RUNTIME_DIR/palpate, or /dev/shm/palpate-<uid> where that variable names no folder; made with mode
// 0700 if it is not there. Refused where the folder belongs to someone else, is a link, or is open to others.
Expected<std::filesystem::path> run_directory();
// Where that is, whether it is there or not; makes nothing.
std::filesystem::path run_directory_place();

// The same checks for a folder of one's own choice; its parent must exist.
Expected<std::filesystem::path> private_directory(const std::filesystem::path& folder);
// The checks alone, of a folder that is there; makes nothing.
Expected<void> check_private_directory(const std::filesystem::path& folder);

}  // namespace palpate::inline core
