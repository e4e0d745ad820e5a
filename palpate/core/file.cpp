#include "palpate/core/file.h"

#include <fcntl.h>
#include <poll.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <chrono>
#include <cstdio>
#include <cstring>
#include <system_error>
#include <thread>

#include "palpate/core/file_descriptor.h"
#include "palpate/core/part_file.h"
#include "palpate/core/stop_signal.h"
#include "palpate/core/system_error.h"

namespace palpate::inline core {

namespace fs = std::filesystem;

namespace {

const char* kind_of_file(mode_t mode) {
  if (S_ISDIR(mode)) return "a folder";
  if (S_ISFIFO(mode)) return "a pipe";
  if (S_ISSOCK(mode)) return "a socket";
  return "a device";
}

Expected<void> check_readable(const fs::path& path, const struct stat& info, std::size_t most) {
  if (!S_ISREG(info.st_mode))
    return wrong_use("{}: is {}, a file is expected", path.string(), kind_of_file(info.st_mode));
  if (static_cast<std::uint64_t>(info.st_size) > most)
    return wrong_use("{}: holds {} bytes; at most {} are expected of such a file", path.string(),
                     info.st_size, most);
  return {};
}

tl::unexpected<Error> cannot_open(const fs::path& path) {
  if (errno == ENOENT || errno == ENOTDIR)
    return wrong_use("{}: no such file; check the path", path.string());
  return wrong_use("{}: cannot be opened ({}); check the path and its permissions", path.string(),
                   reason_of(errno));
}

// Up to `most` bytes and one more, by which the caller sees that there are too many. False: errno.
bool read_up_to(int fd, std::size_t most, std::string& content) {
  std::array<char, 65536> part{};
  while (content.size() <= most) {
    const ssize_t got = ::read(fd, part.data(), std::min(part.size(), most + 1 - content.size()));
    if (got < 0 && errno == EINTR) continue;
    if (got < 0) return false;
    if (got == 0) break;
    content.append(part.data(), static_cast<std::size_t>(got));
  }
  return true;
}

bool same_content(const struct stat& a, const struct stat& b) {
  return a.st_size == b.st_size && a.st_mtim.tv_sec == b.st_mtim.tv_sec &&
         a.st_mtim.tv_nsec == b.st_mtim.tv_nsec;
}

// Of a pipe: until somebody reads it, from the moment it is to be written, and once the program is to end.
constexpr int kReaderWaitMs = 800, kLookEveryMs = 20;

// Until more can be written. Who pages through a pipe is waited for, but not by a program that has been told to
// end. False: errno.
bool wait_for_room(int fd) {
  int waited_ms = 0;
  while (waited_ms < kReaderWaitMs) {
    pollfd item{fd, POLLOUT, 0};
    const int ready = ::poll(&item, 1, kLookEveryMs);
    if (ready > 0) return true;
    if (ready < 0 && errno != EINTR) return false;
    if (told_to_stop()) waited_ms += kLookEveryMs;
  }
  errno = ETIMEDOUT;
  return false;
}

bool write_all(int fd, std::string_view content) {
  while (!content.empty()) {
    const ssize_t count = ::write(fd, content.data(), content.size());
    if (count < 0 && (errno == EINTR || (errno == EAGAIN && wait_for_room(fd)))) continue;
    if (count <= 0) return false;
    content.remove_prefix(static_cast<std::size_t>(count));
  }
  return true;
}

tl::unexpected<Error> not_written(const fs::path& path, const char* what) {
  return refused("{}: {} failed ({}); nothing was changed, free some space and try again", path.string(),
                 what, reason_of(errno));
}

// A pipe that nobody reads cannot be opened without waiting; who reads it may be started at the same time.
FileDescriptor open_device(const fs::path& path) {
  for (int waited_ms = 0;; waited_ms += kLookEveryMs) {
    FileDescriptor file(::open(path.c_str(), O_WRONLY | O_CLOEXEC | O_NONBLOCK | O_NOCTTY));
    if (file || errno != ENXIO || waited_ms >= kReaderWaitMs) return file;
    std::this_thread::sleep_for(std::chrono::milliseconds(kLookEveryMs));
  }
}

// Into a device or a pipe.
Expected<void> write_in_place(const fs::path& path, std::string_view content) {
  const FileDescriptor file = open_device(path);
  if (!file && errno == ENXIO)
    return wrong_use("{}: nobody reads there; start its reader first, or name a file", path.string());
  if (!file)
    return wrong_use("{}: cannot be written ({}); check its permissions", path.string(), reason_of(errno));
  if (write_all(file.get(), content)) return {};
  if (errno == ETIMEDOUT) return refused("{}: its reader takes nothing any more", path.string());
  return not_written(path, "writing");
}

}  // namespace

Expected<std::string> read_file(const fs::path& path, std::size_t most) {
  if (path == "-") return wrong_use("-: standard input is not read; name a file");
  struct stat before {};
  struct stat after {};
  // Looked at before it is opened, for opening alone does something to some devices, and again afterwards,
  // for what was looked at may have been replaced.
  if (::stat(path.c_str(), &before) != 0) return cannot_open(path);
  if (const auto fine = check_readable(path, before, most); !fine) return tl::unexpected(fine.error());
  const FileDescriptor file(::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK | O_NOCTTY));
  if (!file) return cannot_open(path);
  if (::fstat(file.get(), &before) != 0) return cannot_open(path);
  if (const auto fine = check_readable(path, before, most); !fine) return tl::unexpected(fine.error());
  std::string content;
  content.reserve(static_cast<std::size_t>(before.st_size));
  if (!read_up_to(file.get(), most, content) || ::fstat(file.get(), &after) != 0)
    return refused("{}: reading failed ({})", path.string(), reason_of(errno));
  // Of files in /proc and /sys the size is not known.
  const bool whole = before.st_size == 0 || content.size() == static_cast<std::size_t>(before.st_size);
  if (content.size() > most || !whole || !same_content(before, after))
    return refused("{}: changed while it was read; try again when nobody writes to it", path.string());
  return content;
}

bool same_file(const fs::path& a, const fs::path& b) {
  std::error_code code;
  return fs::equivalent(a, b, code) ||
         fs::absolute(a, code).lexically_normal() == fs::absolute(b, code).lexically_normal();
}

bool is_there(const fs::path& path) {
  std::error_code ignored;
  return fs::exists(path, ignored);
}

Expected<void> write_file(const fs::path& path, std::string_view content, FileMode mode) {
  if (path == "-") {
    const auto written = std::fwrite(content.data(), 1, content.size(), stdout);
    if (written != content.size() || std::fflush(stdout) != 0)
      return refused("standard output: writing failed ({})", reason_of(errno));
    return {};
  }
  const fs::path folder = path.has_parent_path() ? path.parent_path() : fs::path(".");
  std::error_code code;
  if (!fs::is_directory(folder, code))
    return wrong_use("{}: the folder {} does not exist; create it first", path.string(), folder.string());
  // Devices and pipes (/dev/stdout, a named pipe) cannot be replaced by a rename: write into them directly.
  const auto status = fs::status(path, code);
  const bool in_place = fs::exists(status) && !fs::is_regular_file(status);
  if (fs::is_directory(status)) return wrong_use("{}: is a folder, a file name is expected", path.string());
  if (in_place) return write_in_place(path, content);
  auto part = PartFile::begin(path);
  if (!part) return tl::unexpected(part.error());
  if (!write_all(part->fd(), content)) return not_written(path, "writing");
  if (const char* failed = part->put_in_place(static_cast<unsigned>(mode))) return not_written(path, failed);
  return {};
}

Expected<void> make_folder(const fs::path& path) {
  std::error_code code;
  fs::create_directories(path, code);
  if (code || !fs::is_directory(path))
    return wrong_use("{}: the folder cannot be created ({})", path.string(),
                     code ? code.message() : "a file is in the way");
  return {};
}

std::string content_hash(std::string_view content) {
  std::uint64_t hash = 1469598103934665603ull;
  for (char c : content) hash = (hash ^ static_cast<unsigned char>(c)) * 1099511628211ull;
  return fmt::format("{:016x}", hash);
}

}  // namespace palpate::inline core
