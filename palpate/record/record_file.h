// The file that a recording is written to: bytes behind bytes, and every failure with the system's words.
//
// Two ways: a live recording grows in place, so that whatever ends the program leaves what was written; what is made of
// another recording is there whole or not at all. A write that fails half way is taken back, so that the file ends where the
// last whole one did. One thread.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

#include "palpate/core/expected.h"
#include "palpate/core/file.h"
#include "palpate/core/file_descriptor.h"
#include "palpate/core/part_file.h"

namespace palpate::record {

enum class Existing : std::uint8_t { refuse, replace };

class RecordFile {
 public:
  // A new file that grows in place. Wrong use where something of that name is there, unless it is a plain file that may be
  // replaced: links are not followed, and devices and pipes not written to.
  static Expected<RecordFile> growing(const std::filesystem::path& path, Existing existing = Existing::refuse,
                                      FileMode mode = FileMode::all);
  // A temporary neighbour of `path` until finish() puts it in place, over a plain file that may be there. "-" is standard
  // output, which gets what is written at once.
  static Expected<RecordFile> whole(const std::filesystem::path& path);

  Expected<void> append(std::string_view bytes);
  // Onto the disk, as far as it was appended (fdatasync).
  Expected<void> sync();
  // Once, after the last append().
  Expected<void> finish();

  std::uint64_t size() const { return size_; }  // bytes appended
  const std::string& name() const { return name_; }

 private:
  RecordFile(std::string name, FileDescriptor file) : name_(std::move(name)), file_(std::move(file)) {}
  RecordFile(std::string name, PartFile part) : name_(std::move(name)), part_(std::move(part)) {}
  int fd() const { return part_ ? part_->fd() : file_.get(); }
  tl::unexpected<Error> failed(const char* what, int error) const;

  std::string name_;
  FileDescriptor file_;
  std::optional<PartFile> part_;
  std::uint64_t size_ = 0;
};

}  // namespace palpate::record
