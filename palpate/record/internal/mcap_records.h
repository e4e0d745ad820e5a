// The records of an MCAP file as bytes, both ways: opcode (1 byte), length (8 bytes), then fields, all little-endian.
//
// A record that is too short for its fields decodes to nothing; what stands behind the fields that are known here is left
// out, as the format wants it. Any thread.
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "palpate/core/little_endian.h"
#include "palpate/record/mcap.h"

namespace palpate::record {

inline constexpr std::string_view kMagic{"\x89MCAP0\r\n", 8};  // the first and the last bytes of a file
inline constexpr std::size_t kRecordHeadBytes = 9;             // opcode and length

enum class Opcode : std::uint8_t {
  none = 0x00,  // never valid
  header = 0x01,
  footer = 0x02,
  schema = 0x03,
  channel = 0x04,
  message = 0x05,
  chunk = 0x06,
  message_index = 0x07,
  chunk_index = 0x08,
  attachment = 0x09,
  attachment_index = 0x0A,
  statistics = 0x0B,
  metadata = 0x0C,
  metadata_index = 0x0D,
  summary_offset = 0x0E,
  data_end = 0x0F,
};
// "Chunk"; "record 0x42" of what is not known.
std::string name_of(Opcode opcode);

// A record in the making: its length is entered by finish().
class RecordBytes {
 public:
  RecordBytes(std::string& out, Opcode opcode) : out_(out), begin_(out.size()) {
    out_ += static_cast<char>(opcode);
    number<std::uint64_t>(0);
  }
  template <typename Number>
  RecordBytes& number(Number value) {
    append_little_endian(out_, value);
    return *this;
  }
  RecordBytes& text(std::string_view text) {  // or bytes, of less than 4 GiB
    number(static_cast<std::uint32_t>(text.size()));
    return bytes(text);
  }
  RecordBytes& words(const Words& words);
  RecordBytes& bytes(std::string_view bytes) {
    out_ += bytes;
    return *this;
  }
  std::size_t content_begin() const { return begin_ + kRecordHeadBytes; }
  void finish();

 private:
  std::string& out_;
  std::size_t begin_;
};

// Reads fields one after the other; what lies beyond the end makes all of it unsound.
class Fields {
 public:
  explicit Fields(std::string_view bytes) : rest_(bytes) {}
  template <typename Number>
  Number number() {
    const auto at = bytes(sizeof(Number));
    return sound_ ? little_endian<Number>(at.data()) : Number{};
  }
  std::string_view bytes(std::uint64_t size) {
    if (size > rest_.size()) sound_ = false;
    if (!sound_) return {};
    const auto taken = rest_.substr(0, size);
    rest_.remove_prefix(size);
    return taken;
  }
  std::string_view text() { return bytes(number<std::uint32_t>()); }
  Words words();
  bool sound() const { return sound_; }
  bool at_end() const { return rest_.empty() || !sound_; }
  std::string_view rest() const { return sound_ ? rest_ : std::string_view(); }

 private:
  std::string_view rest_;
  bool sound_ = true;
};

struct ChunkHead {
  std::uint64_t start_ns = 0, end_ns = 0, uncompressed_size = 0;
  std::uint32_t uncompressed_crc = 0;  // 0: not told
  std::string compression;
  std::string_view records;  // as they are stored
};
// Where the messages of one channel are in the unpacked records of a chunk: log time and offset, one each.
using Places = std::vector<std::pair<std::uint64_t, std::uint64_t>>;
struct MessageIndex {
  std::uint16_t channel = 0;
  Places places;
};
// Offsets are of the file; lengths include opcode and length.
struct ChunkIndex {
  std::uint64_t start_ns = 0, end_ns = 0, offset = 0, length = 0;
  std::map<std::uint16_t, std::uint64_t> message_index_offsets;
  std::uint64_t message_index_length = 0;
  std::string compression;
  std::uint64_t compressed_size = 0, uncompressed_size = 0;
};
struct AttachmentIndex {
  std::uint64_t offset = 0, length = 0, log_time_ns = 0, create_time_ns = 0, data_size = 0;
  std::string name, media_type;
  bool operator==(const AttachmentIndex&) const = default;
};
struct MetadataIndex {
  std::uint64_t offset = 0, length = 0;
  std::string name;
  bool operator==(const MetadataIndex&) const = default;
};
struct SummaryOffset {
  Opcode group = Opcode::none;
  std::uint64_t start = 0, length = 0;
};
struct Footer {
  std::uint64_t summary_start = 0, summary_offset_start = 0;  // 0: there is none
  std::uint32_t summary_crc = 0;                              // 0: not told
};
// Bytes of a footer's content before its CRC, which the CRC covers, too.
inline constexpr std::size_t kFooterBytesBeforeCrc = 16;
inline constexpr std::size_t kFooterBytes = 20;

void append_header(std::string& out, const FileHeader& header);
void append_schema(std::string& out, std::uint16_t id, const Schema& schema);
void append_channel(std::string& out, std::uint16_t id, const Channel& channel);
void append_message(std::string& out, const Message& message);
void append_message_index(std::string& out, std::uint16_t channel, const Places& places);
void append_chunk(std::string& out, const ChunkHead& chunk);
void append_chunk_index(std::string& out, const ChunkIndex& index);
void append_attachment(std::string& out, const Attachment& attachment);
void append_attachment_index(std::string& out, const AttachmentIndex& index);
void append_metadata(std::string& out, const Metadata& metadata);
void append_metadata_index(std::string& out, const MetadataIndex& index);
void append_statistics(std::string& out, const Statistics& statistics);
void append_summary_offset(std::string& out, const SummaryOffset& offset);
void append_data_end(std::string& out, std::uint32_t data_crc);

// Of a record's content. Views are into `content`.
std::optional<FileHeader> decode_header(std::string_view content);
std::optional<std::pair<std::uint16_t, Schema>> decode_schema(std::string_view content);
std::optional<std::pair<std::uint16_t, Channel>> decode_channel(std::string_view content);
std::optional<Message> decode_message(std::string_view content);
std::optional<ChunkHead> decode_chunk(std::string_view content);
std::optional<MessageIndex> decode_message_index(std::string_view content);
std::optional<ChunkIndex> decode_chunk_index(std::string_view content);
struct StoredAttachment {
  Attachment attachment;
  bool crc_right = true;  // also where none is told
};
std::optional<StoredAttachment> decode_attachment(std::string_view content);
std::optional<AttachmentIndex> decode_attachment_index(std::string_view content);
std::optional<Metadata> decode_metadata(std::string_view content);
std::optional<MetadataIndex> decode_metadata_index(std::string_view content);
std::optional<Statistics> decode_statistics(std::string_view content);
std::optional<SummaryOffset> decode_summary_offset(std::string_view content);
std::optional<Footer> decode_footer(std::string_view content);

}  // namespace palpate::record
