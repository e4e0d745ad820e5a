// The temporary neighbour of a file that is being written, which takes the file's place when it is whole.
//
// It is called FILE.part-1, or -2 and so on where several write at once, and is locked as long as its writer
// lives; so whoever writes FILE next can tell what a killed writer has left, and removes it. A file without a
// name (O_TMPFILE) would leave nothing behind, but cannot take the place of one that is there already.
#pragma once

#include <filesystem>
#include <string>

#include "palpate/core/expected.h"

namespace palpate::inline core {

class PartFile {
 public:
  // Wrong use where the folder is missing or may not be written to.
  static Expected<PartFile> begin(const std::filesystem::path& target);
  ~PartFile();  // gone with this object unless it has been put in place
  PartFile(PartFile&& other) noexcept;
  PartFile& operator=(PartFile&&) = delete;

  int fd() const { return fd_; }
  // Once: onto the disk, with these permissions, under the target's name. What failed, with errno; nullptr:
  // nothing has.
  const char* put_in_place(unsigned mode);

 private:
  PartFile(std::filesystem::path target, std::string name, int fd)
      : target_(std::move(target)), name_(std::move(name)), fd_(fd) {}

  std::filesystem::path target_;
  std::string name_;  // empty: put in place
  int fd_ = -1;
};

}  // namespace palpate::inline core
