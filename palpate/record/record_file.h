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

  // Takes back what was appended beyond `size`. Not of standard output, where it may be gone already and where others
  // may have written before.
  void cut_back(std::uint64_t size);

  std::uint64_t size() const { return size_; }  // bytes appended
  const std::string& name() const { return name_; }
  const std::filesystem::path& path() const { return path_; }  // empty: standard output
  // That what belongs to writing this file failed, as each of its own failures is told.
  tl::unexpected<Error> failed(const char* what, int error) const;

 private:
  explicit RecordFile(FileDescriptor standard_output)
      : name_("standard output"), file_(std::move(standard_output)) {}
  RecordFile(const std::filesystem::path& path, FileDescriptor file)
      : name_(path.string()), path_(path), file_(std::move(file)) {}
  RecordFile(const std::filesystem::path& path, PartFile part)
      : name_(path.string()), path_(path), part_(std::move(part)) {}
  int fd() const { return part_ ? part_->fd() : file_.get(); }

  std::string name_;
  std::filesystem::path path_;
  FileDescriptor file_;
  std::optional<PartFile> part_;
  std::uint64_t size_ = 0;
};

}  // namespace palpate::record
