// A lock on a file that is made for it. The kernel drops it when its process ends, however it ends: no stale lock, no
// guessing by process number. Whoever holds it may remove the file, as long as it does so before it lets go. Any thread.
#pragma once

#include <filesystem>
#include <optional>

#include "palpate/core/expected.h"
#include "palpate/core/file_descriptor.h"

namespace palpate::inline core {

// Whether the name still means this open file; links are not followed.
bool is_at(const std::filesystem::path& path, int fd);

// Makes the file where there is none (for this user alone) and locks it; none where another process holds the lock.
// Refused: a file that cannot be opened or locked.
Expected<std::optional<FileDescriptor>> lock_file(const std::filesystem::path& path);

}  // namespace palpate::inline core
