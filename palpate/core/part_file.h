// The temporary neighbour of a file that is being written, which takes the file's place when it is whole.
//
// It is called FILE.part-1, or -2 and so on where several write at once, and is locked as long as its writer
// lives; so whoever writes FILE next can tell what a killed writer has left, and removes it. A file without a
// name (O_TMPFILE) would leave nothing behind, but cannot take the place of one that is there already.
//
// For files too large to be kept in memory; write_file() (file.h) does the same with a text. One thread.
#pragma once

#include <filesystem>
#include <string>

#include "palpate/core/expected.h"
#include "palpate/core/file_descriptor.h"

namespace palpate::inline core {

class PartFile {
 public:
  // Wrong use where the folder is missing or may not be written to.
  static Expected<PartFile> begin(const std::filesystem::path& target);
  ~PartFile();  // gone with this object unless it has been put in place
  PartFile(PartFile&& other) noexcept;
  PartFile& operator=(PartFile&&) = delete;

  int fd() const { return fd_.get(); }
  // Once: onto the disk, with these permissions, under the target's name. What failed, with errno; nullptr:
  // nothing has.
  const char* put_in_place(unsigned mode);

 private:
  PartFile(std::filesystem::path target, std::string name, FileDescriptor fd)
      : target_(std::move(target)), name_(std::move(name)), fd_(std::move(fd)) {}

  std::filesystem::path target_;
  std::string name_;  // empty: put in place
  FileDescriptor fd_;
};

}  // namespace palpate::inline core
