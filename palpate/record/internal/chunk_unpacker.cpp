#include "palpate/record/internal/chunk_unpacker.h"

#include "palpate/core/text.h"
#include "palpate/record/internal/crc32.h"

namespace palpate::record {

Expected<std::optional<std::string_view>> ChunkUnpacker::unpack(const ChunkHead& chunk, std::string& why) {
  std::optional<std::string_view> records;
  if (chunk.compression == "lz4")
    return refused(
        "{}: its chunks are packed with lz4, which is not read here; zstd or none is expected, pack it anew",
        name_);
  if (chunk.uncompressed_size > most_bytes_) {
    why = fmt::format("says that it holds {} bytes; at most {} are expected", chunk.uncompressed_size,
                      most_bytes_);
    return records;
  }
  if (chunk.compression.empty()) {
    if (chunk.records.size() == chunk.uncompressed_size) records = chunk.records;
  } else if (chunk.compression == "zstd") {
    records = decompressor_.decompress(chunk.records, chunk.uncompressed_size);
  } else {
    why = fmt::format("is packed with '{}'; zstd or none is expected", excerpt(chunk.compression));
    return records;
  }
  if (!records) why = fmt::format("does not hold the {} bytes that it says", chunk.uncompressed_size);
  if (records && chunk.uncompressed_crc != 0 && crc32(*records) != chunk.uncompressed_crc) {
    why = "its CRC is wrong";
    records.reset();
  }
  return records;
}

}  // namespace palpate::record
