#include "palpate/core/file_lock.h"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>

#include <cerrno>
#include <utility>

#include "palpate/core/system_error.h"

namespace palpate::inline core {

bool is_at(const std::filesystem::path& path, int fd) {
  struct stat there {};
  struct stat here {};
  return ::lstat(path.c_str(), &there) == 0 && ::fstat(fd, &here) == 0 && there.st_ino == here.st_ino &&
         there.st_dev == here.st_dev;
}

Expected<std::optional<FileDescriptor>> lock_file(const std::filesystem::path& path) {
  constexpr int kMostTries = 100;  // of a lock that others take and give up again and again
  for (int attempt = 0; attempt < kMostTries; ++attempt) {
    FileDescriptor lock(::open(path.c_str(), O_RDWR | O_CREAT | O_CLOEXEC | O_NOFOLLOW, 0600));
    if (!lock) return refused("{}: cannot be opened ({}); check the folder", path.string(), reason_of(errno));
    if (::flock(lock.get(), LOCK_EX | LOCK_NB) != 0) {
      if (errno == EWOULDBLOCK) return std::optional<FileDescriptor>();
      return refused("{}: cannot be locked ({}); choose a folder of another file system", path.string(),
                     reason_of(errno));
    }
    // Between opening and locking its last holder may have removed it: then nobody else would meet this lock.
    if (is_at(path, lock.get())) return std::optional(std::move(lock));
  }
  return refused("{}: others keep taking the lock; try again", path.string());
}

}  // namespace palpate::inline core
