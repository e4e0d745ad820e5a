// A part of a source in memory, read ahead, so that small records cost no call of the system each. One thread.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <string_view>
#include <vector>

#include "palpate/record/byte_source.h"

namespace palpate::record {

class SourceWindow {
 public:
  explicit SourceWindow(ByteSource& source) : source_(source) {}

  // Bytes that lie within the source; valid until the next call. The caller bounds `count`.
  Expected<std::string_view> view(std::uint64_t offset, std::size_t count) {
    if (offset < begin_ || offset + count > begin_ + held_) {
      const auto there = source_.size() - offset;
      const auto wanted = static_cast<std::size_t>(std::min<std::uint64_t>(std::max(count, kAhead), there));
      if (bytes_.size() < wanted) bytes_.resize(wanted);
      held_ = 0;
      if (auto done = source_.read(offset, bytes_.data(), wanted); !done) return tl::unexpected(done.error());
      begin_ = offset;
      held_ = wanted;
    }
    return std::string_view(bytes_.data() + (offset - begin_), count);
  }

 private:
  static constexpr std::size_t kAhead = 256 * 1024;
  ByteSource& source_;
  std::vector<char> bytes_;
  std::uint64_t begin_ = 0;
  std::size_t held_ = 0;
};

}  // namespace palpate::record
