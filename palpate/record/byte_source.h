// Where a recording is read from: a plain file, of which only the part that is looked at is in memory, or bytes.
//
// The size is that at the opening: what a writer adds meanwhile is not seen. One thread.
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <memory>
#include <string>
#include <string_view>

#include "palpate/core/expected.h"

namespace palpate::record {

class ByteSource {
 public:
  virtual ~ByteSource() = default;
  virtual std::uint64_t size() const = 0;
  virtual const std::string& name() const = 0;  // for messages
  // All `count` bytes from `offset` on, which lie within the size. Refused where the file has shrunk or cannot be read.
  virtual Expected<void> read(std::uint64_t offset, char* to, std::size_t count) = 0;
};

// Wrong use where it is missing or anything but a plain file.
Expected<std::unique_ptr<ByteSource>> open_source(const std::filesystem::path& path);

// `bytes` outlive it.
class MemorySource : public ByteSource {
 public:
  explicit MemorySource(std::string_view bytes, std::string name = "recording")
      : bytes_(bytes), name_(std::move(name)) {}
  std::uint64_t size() const override { return bytes_.size(); }
  const std::string& name() const override { return name_; }
  Expected<void> read(std::uint64_t offset, char* to, std::size_t count) override {
    std::memcpy(to, bytes_.data() + offset, count);
    return {};
  }

 private:
  std::string_view bytes_;
  std::string name_;
};

}  // namespace palpate::record
