#include "palpate/record/internal/chunk_search.h"

#include <algorithm>
#include <string>

#include "palpate/record/internal/mcap_records.h"

namespace palpate::record {
namespace {

constexpr int kMostFailures = 200;
constexpr std::uint64_t kMostFailedBytes = 1024ull * 1024 * 1024;
constexpr std::uint64_t kPiece = 256 * 1024;
constexpr std::string_view kMark{"\x04\0\0\0zstd", 8};
constexpr std::uint64_t kMarkAt = kRecordHeadBytes + 28;              // in a chunk
constexpr std::uint64_t kHeadBytes = kMarkAt + kMark.size() + 8;      // until its records begin
constexpr std::uint64_t kFieldBytes = kHeadBytes - kRecordHeadBytes;  // of its content, before its records

// The length of the record that begins with `head`, where its fields agree about it.
std::optional<std::uint64_t> length_of(std::string_view head) {
  const auto length = little_endian<std::uint64_t>(head.data() + 1);
  const auto records = little_endian<std::uint64_t>(head.data() + kHeadBytes - 8);
  if (head.front() != static_cast<char>(Opcode::chunk) || length < kFieldBytes ||
      length - kFieldBytes != records)
    return std::nullopt;
  return length;
}

}  // namespace

Expected<std::optional<std::uint64_t>> ChunkSearch::first_from(std::uint64_t offset) {
  from_ = std::max(from_, offset);
  while (from_ + kHeadBytes <= size_ && failures_ < kMostFailures && failed_bytes_ < kMostFailedBytes) {
    const auto part = std::min(kPiece, size_ - from_);
    const auto piece = window_.view(from_, static_cast<std::size_t>(part));
    if (!piece) return tl::unexpected(piece.error());
    std::optional<std::uint64_t> length;
    std::uint64_t begin = 0;  // in the piece
    for (auto hit = piece->find(kMark, kMarkAt); hit != std::string_view::npos;
         hit = piece->find(kMark, hit + 1)) {
      begin = hit - kMarkAt;
      if (begin + kHeadBytes > part) break;  // in the next piece
      length = length_of(piece->substr(begin));
      if (length && (*length > most_record_bytes_ || *length > size_ - from_ - begin - kRecordHeadBytes))
        length.reset();
      if (length) break;
    }
    if (!length) {
      from_ += part - kHeadBytes + 1;
      continue;
    }
    const auto candidate = from_ + begin;
    from_ = candidate + 1;
    const auto sound = is_sound(candidate, kRecordHeadBytes + *length);
    if (!sound) return tl::unexpected(sound.error());
    if (*sound) return std::optional<std::uint64_t>(candidate);
  }
  return std::optional<std::uint64_t>();
}

Expected<bool> ChunkSearch::is_sound(std::uint64_t offset, std::uint64_t length) {
  const auto bytes = window_.view(offset, static_cast<std::size_t>(length));
  if (!bytes) return tl::unexpected(bytes.error());
  const auto chunk = decode_chunk(bytes->substr(kRecordHeadBytes));
  if (!chunk || chunk->uncompressed_crc == 0) {
    ++failures_;
    return false;
  }
  std::string why;
  const auto records = unpacker_.unpack(*chunk, why);
  if (!records) return tl::unexpected(records.error());
  if (*records) return true;
  ++failures_;
  failed_bytes_ += std::min(chunk->uncompressed_size, kMostChunkBytes);
  return false;
}

}  // namespace palpate::record
