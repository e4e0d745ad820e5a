#include "palpate/record/byte_source.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <utility>

#include "palpate/core/file_descriptor.h"
#include "palpate/core/system_error.h"

namespace palpate::record {
namespace {

class FileSource : public ByteSource {
 public:
  FileSource(std::string name, FileDescriptor file, std::uint64_t size)
      : name_(std::move(name)), file_(std::move(file)), size_(size) {}
  std::uint64_t size() const override { return size_; }
  const std::string& name() const override { return name_; }

  Expected<void> read(std::uint64_t offset, char* to, std::size_t count) override {
    while (count > 0) {
      const ssize_t got = ::pread(file_.get(), to, count, static_cast<off_t>(offset));
      if (got < 0 && errno == EINTR) continue;
      if (got < 0) return refused("{}: reading failed ({})", name_, reason_of(errno));
      if (got == 0)
        return refused("{}: changed while it was read; try again when nobody writes to it", name_);
      to += got;
      offset += static_cast<std::uint64_t>(got);
      count -= static_cast<std::size_t>(got);
    }
    return {};
  }

 private:
  std::string name_;
  FileDescriptor file_;
  std::uint64_t size_;
};

tl::unexpected<Error> cannot_open(const std::filesystem::path& path, int error) {
  if (error == ENOENT || error == ENOTDIR)
    return wrong_use("{}: no such file; check the path", path.string());
  return wrong_use("{}: cannot be opened ({}); check the path and its permissions", path.string(),
                   reason_of(error));
}

}  // namespace

Expected<std::unique_ptr<ByteSource>> open_source(const std::filesystem::path& path) {
  if (path == "-") return wrong_use("-: standard input is not read; name a file");
  struct stat info {};
  const auto plain = [&] { return S_ISREG(info.st_mode); };
  // Looked at before it is opened, for opening alone does something to some devices, and again afterwards.
  if (::stat(path.c_str(), &info) != 0) return cannot_open(path, errno);
  if (!plain()) return wrong_use("{}: is no plain file, a recording is expected", path.string());
  FileDescriptor file(::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK | O_NOCTTY));
  if (!file || ::fstat(file.get(), &info) != 0) return cannot_open(path, errno);
  if (!plain()) return wrong_use("{}: is no plain file, a recording is expected", path.string());
  return std::make_unique<FileSource>(path.string(), std::move(file),
                                      static_cast<std::uint64_t>(info.st_size));
}

}  // namespace palpate::record
