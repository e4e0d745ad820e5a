#include "palpate/core/part_file.h"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <utility>

#include "palpate/core/file_lock.h"

namespace palpate::inline core {
namespace {

namespace fs = std::filesystem;

constexpr int kPlaces = 8;      // as many write one file at once before names are drawn by lot
constexpr int kMostTries = 64;  // of a place that others take away again and again

std::string place(const fs::path& target, int number) {
  return target.string() + ".part-" + std::to_string(number);
}

// Removes what is at this place if its writer has gone: then nobody holds its lock. Of a file system that
// knows no locks, and of what is not ours, everything stays.
void remove_left_behind(const std::string& name) {
  struct stat found {};
  if (::lstat(name.c_str(), &found) != 0 || !S_ISREG(found.st_mode) || found.st_uid != ::geteuid()) return;
  const FileDescriptor fd(::open(name.c_str(), O_RDONLY | O_CLOEXEC | O_NOFOLLOW | O_NONBLOCK));
  if (!fd) return;
  // While we hold the lock, nobody else who keeps to it removes or renames the file.
  if (::flock(fd.get(), LOCK_EX | LOCK_NB) == 0 && is_at(name, fd.get())) ::unlink(name.c_str());
}

// A new file at this place, locked; none: errno, EEXIST where the place is taken.
FileDescriptor take(const std::string& name) {
  FileDescriptor fd(::open(name.c_str(), O_RDWR | O_CREAT | O_EXCL | O_CLOEXEC | O_NOFOLLOW, 0600));
  if (!fd) return fd;
  const bool locked = ::flock(fd.get(), LOCK_EX | LOCK_NB) == 0 || errno != EWOULDBLOCK;
  // Before it was locked, another may have taken it for one left behind.
  if (locked && is_at(name, fd.get())) return fd;
  errno = EEXIST;
  return FileDescriptor();
}

}  // namespace

Expected<PartFile> PartFile::begin(const fs::path& target) {
  for (int number = 1; number <= kPlaces; ++number) remove_left_behind(place(target, number));
  for (int attempt = 0; attempt < kMostTries; ++attempt) {
    std::string name = place(target, 1 + attempt % kPlaces);
    FileDescriptor fd = take(name);
    if (fd) return PartFile(target, std::move(name), std::move(fd));
    if (errno != EEXIST) break;
  }
  // All places are taken: a name that nobody can foresee.
  if (errno == EEXIST) {
    std::string name = target.string() + ".part-XXXXXX";
    FileDescriptor fd(::mkostemp(name.data(), O_CLOEXEC));
    if (fd) return PartFile(target, std::move(name), std::move(fd));
  }
  return wrong_use("{}: cannot be written ({}); check the folder and its permissions", target.string(),
                   std::strerror(errno));
}

PartFile::PartFile(PartFile&& other) noexcept
    : target_(std::move(other.target_)), name_(std::exchange(other.name_, {})), fd_(std::move(other.fd_)) {}

PartFile::~PartFile() {
  const int error = errno;  // of what has failed
  if (!name_.empty()) ::unlink(name_.c_str());
  errno = error;
}

const char* PartFile::put_in_place(unsigned mode) {
  if (::fchmod(fd(), static_cast<mode_t>(mode)) != 0) return "setting permissions";
  if (::fsync(fd()) != 0) return "writing to disk";
  // Closed only afterwards: without its lock it would pass for one left behind.
  if (::rename(name_.c_str(), target_.c_str()) != 0) return "putting it in place";
  name_.clear();
  return nullptr;
}

}  // namespace palpate::inline core
