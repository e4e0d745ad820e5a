#include "palpate/record/internal/spilled_bytes.h"

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>

#include "palpate/core/part_file.h"

namespace palpate::record {
namespace {

namespace fs = std::filesystem;

// 0, or errno. What was written before a failure is written over by whoever tries again.
int write_at(int fd, std::string_view bytes, std::uint64_t offset) {
  while (!bytes.empty()) {
    const ssize_t count = ::pwrite(fd, bytes.data(), bytes.size(), static_cast<off_t>(offset));
    if (count < 0 && errno == EINTR) continue;
    if (count <= 0) return count == 0 ? ENOSPC : errno;
    bytes.remove_prefix(static_cast<std::size_t>(count));
    offset += static_cast<std::uint64_t>(count);
  }
  return 0;
}

}  // namespace

FileDescriptor nameless_file(const fs::path& neighbour) {
  const fs::path folder = neighbour.has_parent_path() ? neighbour.parent_path() : fs::path(".");
  FileDescriptor file(::open(folder.c_str(), O_RDWR | O_TMPFILE | O_EXCL | O_CLOEXEC, 0600));
  // FAT and NFS know none, and tell it in different words.
  return file ? std::move(file) : unlinked_file(neighbour);
}

FileDescriptor unlinked_file(const fs::path& neighbour) {
  const auto part = PartFile::begin(neighbour);
  return FileDescriptor(part ? ::fcntl(part->fd(), F_DUPFD_CLOEXEC, 0) : -1);
}

int SpilledBytes::append(std::string_view bytes) {
  if (file_ && memory_.size() + bytes.size() > kInMemory) {
    if (const int error = write_at(file_.get(), memory_, in_file_); error != 0) return error;
    in_file_ += memory_.size();
    memory_.clear();
  }
  memory_ += bytes;
  return 0;
}

int SpilledBytes::read(std::uint64_t offset, std::string& part) const {
  if (offset >= in_file_) {
    part = memory_.substr(static_cast<std::size_t>(offset - in_file_));
    return 0;
  }
  part.resize(static_cast<std::size_t>(std::min<std::uint64_t>(kInMemory, in_file_ - offset)));
  for (;;) {
    const ssize_t count = ::pread(file_.get(), part.data(), part.size(), static_cast<off_t>(offset));
    if (count < 0 && errno == EINTR) continue;
    if (count <= 0) return count == 0 ? EIO : errno;
    part.resize(static_cast<std::size_t>(count));
    return 0;
  }
}

}  // namespace palpate::record
