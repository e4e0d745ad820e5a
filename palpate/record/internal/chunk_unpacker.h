// The records of a chunk as they were before it was packed, where its size and its CRC are right. One thread.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "palpate/core/expected.h"
#include "palpate/record/internal/compression.h"
#include "palpate/record/internal/mcap_records.h"

namespace palpate::record {

class ChunkUnpacker {
 public:
  // `name` of the file, for messages; chunks that hold more than `most_bytes` are refused.
  ChunkUnpacker(std::string name, std::uint64_t most_bytes)
      : name_(std::move(name)), most_bytes_(most_bytes) {}

  // Nothing where it is damaged: then `why` says so. Refused where it is packed with what nobody here can unpack. Valid until
  // the next call, and as long as the chunk.
  Expected<std::optional<std::string_view>> unpack(const ChunkHead& chunk, std::string& why);

 private:
  std::string name_;
  std::uint64_t most_bytes_;
  Decompressor decompressor_;
};

}  // namespace palpate::record
