#include "palpate/record/record_file.h"

#include <fcntl.h>
#include <poll.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>

#include "palpate/core/system_error.h"

namespace palpate::record {
namespace {

namespace fs = std::filesystem;

tl::unexpected<Error> cannot_be_made(const fs::path& path, int error) {
  return wrong_use("{}: cannot be written ({}); check the folder and its permissions", path.string(),
                   reason_of(error));
}

// Nothing there, or a plain file that may go. Looked at without following links.
Expected<void> make_room(const fs::path& path, Existing existing) {
  struct stat found {};
  if (::lstat(path.c_str(), &found) != 0) return {};
  if (existing == Existing::refuse)
    return wrong_use("{}: exists already; choose another name", path.string());
  if (!S_ISREG(found.st_mode))
    return wrong_use("{}: is no plain file; the name of a new file is expected", path.string());
  if (::unlink(path.c_str()) != 0) return cannot_be_made(path, errno);
  return {};
}

Expected<void> folder_is_there(const fs::path& path) {
  const fs::path folder = path.has_parent_path() ? path.parent_path() : fs::path(".");
  std::error_code code;
  if (!fs::is_directory(folder, code))
    return wrong_use("{}: the folder {} does not exist; create it first", path.string(), folder.string());
  return {};
}

}  // namespace

Expected<RecordFile> RecordFile::growing(const fs::path& path, Existing existing, FileMode mode) {
  if (auto fine = folder_is_there(path); !fine) return tl::unexpected(fine.error());
  if (auto room = make_room(path, existing); !room) return tl::unexpected(room.error());
  FileDescriptor file(::open(path.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC | O_NOFOLLOW | O_NOCTTY,
                             static_cast<mode_t>(mode)));
  if (!file && errno == EEXIST) return wrong_use("{}: exists already; choose another name", path.string());
  if (!file) return cannot_be_made(path, errno);
  // That there is such a file is on the disk only with its folder. Some file systems cannot, and need not.
  const auto folder = path.has_parent_path() ? path.parent_path() : fs::path(".");
  if (const FileDescriptor above(::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC)); above)
    ::fsync(above.get());
  return RecordFile(path, std::move(file));
}

Expected<RecordFile> RecordFile::whole(const fs::path& path) {
  if (path == "-") {
    FileDescriptor out(::fcntl(STDOUT_FILENO, F_DUPFD_CLOEXEC, 0));
    if (!out) return refused("standard output: cannot be written ({})", reason_of(errno));
    return RecordFile(std::move(out));
  }
  if (auto fine = folder_is_there(path); !fine) return tl::unexpected(fine.error());
  std::error_code code;
  const auto status = fs::status(path, code);
  if (fs::is_directory(status)) return wrong_use("{}: is a folder, a file name is expected", path.string());
  if (fs::exists(status) && !fs::is_regular_file(status))
    return wrong_use("{}: is no plain file; a file name is expected, or - for standard output",
                     path.string());
  auto part = PartFile::begin(path);
  if (!part) return tl::unexpected(part.error());
  return RecordFile(path, std::move(*part));
}

tl::unexpected<Error> RecordFile::failed(const char* what, int error) const {
  if (part_)
    return refused("{}: {} failed ({}); nothing was changed, free some space and try again", name_, what,
                   reason_of(error));
  return refused("{}: {} failed ({}); the recording ends there, free some space and record anew", name_, what,
                 reason_of(error));
}

Expected<void> RecordFile::append(std::string_view bytes) {
  for (auto rest = bytes; !rest.empty();) {
    const ssize_t count = ::write(fd(), rest.data(), rest.size());
    if (count < 0 && errno == EINTR) continue;
    if (count < 0 && errno == EAGAIN) {  // a pipe that others have set not to wait
      pollfd item{fd(), POLLOUT, 0};
      ::poll(&item, 1, 100);
      continue;
    }
    if (count <= 0) {
      const int error = count == 0 ? ENOSPC : errno;
      cut_back(size_);
      return failed("writing", error);
    }
    rest.remove_prefix(static_cast<std::size_t>(count));
  }
  size_ += bytes.size();
  return {};
}

void RecordFile::cut_back(std::uint64_t size) {
  if (path_.empty()) return;
  [[maybe_unused]] const int ignored = ::ftruncate(fd(), static_cast<off_t>(size));
  size_ = size;
}

Expected<void> RecordFile::sync() {
  // A pipe knows no disk.
  if (::fdatasync(fd()) != 0 && errno != EINVAL && errno != EROFS) return failed("writing to disk", errno);
  return {};
}

Expected<void> RecordFile::finish() {
  if (!part_) return sync();
  if (const char* what = part_->put_in_place(static_cast<unsigned>(FileMode::all)))
    return failed(what, errno);
  return {};
}

}  // namespace palpate::record
