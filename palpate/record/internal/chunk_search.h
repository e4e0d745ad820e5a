// Looks for a chunk that is sound in a file where nothing tells where the next record begins. Chunks are recognised by the
// name of their packing, so those that are not packed are not found; what no CRC covers is not believed.
//
// The work is bounded whatever the file holds: its bytes are looked through once, and at most 200 chunks that only look sound
// are unpacked, of 1 GiB together. One thread.
#pragma once

#include <cstdint>
#include <optional>

#include "palpate/core/expected.h"
#include "palpate/record/internal/chunk_unpacker.h"
#include "palpate/record/internal/source_window.h"

namespace palpate::record {

class ChunkSearch {
 public:
  // All of them outlive it. `size` of the file; records of more than `most_record_bytes` are left out.
  ChunkSearch(SourceWindow& window, ChunkUnpacker& unpacker, std::uint64_t size,
              std::uint64_t most_record_bytes)
      : window_(window), unpacker_(unpacker), size_(size), most_record_bytes_(most_record_bytes) {}

  // The first one that begins at `offset` or behind it; offsets of later calls are higher.
  Expected<std::optional<std::uint64_t>> first_from(std::uint64_t offset);

 private:
  Expected<bool> is_sound(std::uint64_t offset, std::uint64_t length);

  SourceWindow& window_;
  ChunkUnpacker& unpacker_;
  const std::uint64_t size_, most_record_bytes_;
  std::uint64_t from_ = 0;  // chunks that begin before are known
  int failures_ = 0;
  std::uint64_t failed_bytes_ = 0;  // that they would have held
};

}  // namespace palpate::record
