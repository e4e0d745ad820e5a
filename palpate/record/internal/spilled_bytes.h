// Bytes that gather as long as a recording runs and are needed once, at its end: what memory does not keep goes into a file
// without a name beside the recording, of which nothing is left however the program ends. One thread.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <utility>

#include "palpate/core/file_descriptor.h"

namespace palpate::record {

// A file without a name in the folder of `neighbour`; none where the system makes none, errno says why.
FileDescriptor nameless_file(const std::filesystem::path& neighbour);
// The same where the file system makes only files with names: for a moment it has one.
FileDescriptor unlinked_file(const std::filesystem::path& neighbour);

class SpilledBytes {
 public:
  static constexpr std::size_t kInMemory =
      64 * 1024;  // and the least that is written at once, but for longer pieces

  // Without a file all of it stays in memory.
  explicit SpilledBytes(FileDescriptor file = FileDescriptor()) : file_(std::move(file)) {}

  // Both: 0, or what failed (errno). After a failure everything that was there before is still to be read.
  int append(std::string_view bytes);
  // What stands at `offset`, below size(): at least one byte.
  int read(std::uint64_t offset, std::string& part) const;

  std::uint64_t size() const { return in_file_ + memory_.size(); }
  std::size_t in_memory() const { return memory_.size(); }

 private:
  FileDescriptor file_;
  std::uint64_t in_file_ = 0;
  std::string memory_;  // what comes behind
};

}  // namespace palpate::record
