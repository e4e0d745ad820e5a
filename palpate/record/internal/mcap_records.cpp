#include "palpate/record/internal/mcap_records.h"

#include <fmt/format.h>

#include <bit>
#include <cstring>

#include "palpate/record/internal/crc32.h"

namespace palpate::record {

std::string name_of(Opcode opcode) {
  static constexpr const char* kNames[] = {"record 0x00", "Header",        "Footer",          "Schema",
                                           "Channel",     "Message",       "Chunk",           "MessageIndex",
                                           "ChunkIndex",  "Attachment",    "AttachmentIndex", "Statistics",
                                           "Metadata",    "MetadataIndex", "SummaryOffset",   "DataEnd"};
  const auto number = static_cast<std::size_t>(opcode);
  return number < std::size(kNames) ? kNames[number] : fmt::format("record {:#04x}", number);
}

void RecordBytes::finish() {
  std::string length;
  append_little_endian(length, static_cast<std::uint64_t>(out_.size() - content_begin()));
  out_.replace(begin_ + 1, length.size(), length);
}

RecordBytes& RecordBytes::words(const Words& words) {
  std::size_t size = 0;
  for (const auto& [key, value] : words) size += 8 + key.size() + value.size();
  number(static_cast<std::uint32_t>(size));
  for (const auto& [key, value] : words) text(key).text(value);
  return *this;
}

Words Fields::words() {
  Words words;
  Fields inner(text());
  while (!inner.at_end()) {
    const auto key = inner.text();
    const auto value = inner.text();
    if (inner.sound() && !words.emplace(key, value).second) sound_ = false;  // a key twice
  }
  if (!inner.sound()) sound_ = false;
  return words;
}

namespace {

using u16 = std::uint16_t;
using u32 = std::uint32_t;
using u64 = std::uint64_t;

// What was decoded, where the record was long enough.
template <typename T>
std::optional<T> if_sound(const Fields& fields, T value) {
  std::optional<T> sound;
  if (fields.sound()) sound.emplace(std::move(value));
  return sound;
}

void add_numbers(RecordBytes& record, const std::map<u16, u64>& numbers) {
  record.number(static_cast<u32>(10 * numbers.size()));
  for (const auto& [key, value] : numbers) record.number(key).number(value);
}

std::map<u16, u64> numbers_of(Fields& fields) {
  std::map<u16, u64> numbers;
  Fields inner(fields.text());
  bool sound = true;
  while (!inner.at_end()) {
    const auto key = inner.number<u16>();
    const auto value = inner.number<u64>();
    if (inner.sound() && !numbers.emplace(key, value).second) sound = false;  // a channel twice
  }
  if (!inner.sound() || !sound) fields.bytes(~u64{0});  // makes the whole unsound
  return numbers;
}

}  // namespace

void append_header(std::string& out, const FileHeader& header) {
  RecordBytes(out, Opcode::header).text(header.profile).text(header.library).finish();
}
std::optional<FileHeader> decode_header(std::string_view content) {
  Fields fields(content);
  FileHeader header;
  header.profile = fields.text();
  header.library = fields.text();
  return if_sound(fields, std::move(header));
}

void append_schema(std::string& out, u16 id, const Schema& schema) {
  RecordBytes(out, Opcode::schema)
      .number(id)
      .text(schema.name)
      .text(schema.encoding)
      .text(schema.data)
      .finish();
}
std::optional<std::pair<u16, Schema>> decode_schema(std::string_view content) {
  Fields fields(content);
  std::pair<u16, Schema> schema;
  schema.first = fields.number<u16>();
  schema.second.name = fields.text();
  schema.second.encoding = fields.text();
  schema.second.data = fields.text();
  if (schema.first == 0) return std::nullopt;  // which says "none" in a channel
  return if_sound(fields, std::move(schema));
}

void append_channel(std::string& out, u16 id, const Channel& channel) {
  RecordBytes record(out, Opcode::channel);
  record.number(id).number(channel.schema).text(channel.topic).text(channel.message_encoding);
  record.words(channel.metadata).finish();
}
std::optional<std::pair<u16, Channel>> decode_channel(std::string_view content) {
  Fields fields(content);
  std::pair<u16, Channel> channel;
  channel.first = fields.number<u16>();
  channel.second.schema = fields.number<u16>();
  channel.second.topic = fields.text();
  channel.second.message_encoding = fields.text();
  channel.second.metadata = fields.words();
  return if_sound(fields, std::move(channel));
}

void append_message(std::string& out, const Message& message) {
  RecordBytes record(out, Opcode::message);
  record.number(message.channel).number(message.sequence);
  record.number(message.log_time_ns).number(message.publish_time_ns).bytes(message.data).finish();
}
std::optional<Message> decode_message(std::string_view content) {
  Fields fields(content);
  Message message;
  message.channel = fields.number<u16>();
  message.sequence = fields.number<u32>();
  message.log_time_ns = fields.number<u64>();
  message.publish_time_ns = fields.number<u64>();
  message.data = fields.rest();
  return if_sound(fields, message);
}

void append_chunk(std::string& out, const ChunkHead& chunk) {
  RecordBytes record(out, Opcode::chunk);
  record.number(chunk.start_ns).number(chunk.end_ns).number(chunk.uncompressed_size);
  record.number(chunk.uncompressed_crc).text(chunk.compression);
  record.number(static_cast<u64>(chunk.records.size())).bytes(chunk.records).finish();
}
std::optional<ChunkHead> decode_chunk(std::string_view content) {
  Fields fields(content);
  ChunkHead chunk;
  chunk.start_ns = fields.number<u64>();
  chunk.end_ns = fields.number<u64>();
  chunk.uncompressed_size = fields.number<u64>();
  chunk.uncompressed_crc = fields.number<u32>();
  chunk.compression = fields.text();
  chunk.records = fields.bytes(fields.number<u64>());
  return if_sound(fields, std::move(chunk));
}

void append_message_index(std::string& out, u16 channel, const Places& places) {
  RecordBytes record(out, Opcode::message_index);
  record.number(channel).number(static_cast<u32>(16 * places.size()));
  for (const auto& [time, offset] : places) record.number(time).number(offset);
  record.finish();
}
std::optional<MessageIndex> decode_message_index(std::string_view content) {
  Fields fields(content);
  MessageIndex index;
  index.channel = fields.number<u16>();
  Fields inner(fields.text());
  while (!inner.at_end()) {
    const auto time = inner.number<u64>();
    index.places.emplace_back(time, inner.number<u64>());
  }
  if (!inner.sound()) return std::nullopt;
  return if_sound(fields, std::move(index));
}

void append_chunk_index(std::string& out, const ChunkIndex& index) {
  RecordBytes record(out, Opcode::chunk_index);
  record.number(index.start_ns).number(index.end_ns).number(index.offset).number(index.length);
  add_numbers(record, index.message_index_offsets);
  record.number(index.message_index_length).text(index.compression);
  record.number(index.compressed_size).number(index.uncompressed_size).finish();
}
std::optional<ChunkIndex> decode_chunk_index(std::string_view content) {
  Fields fields(content);
  ChunkIndex index;
  index.start_ns = fields.number<u64>();
  index.end_ns = fields.number<u64>();
  index.offset = fields.number<u64>();
  index.length = fields.number<u64>();
  index.message_index_offsets = numbers_of(fields);
  index.message_index_length = fields.number<u64>();
  index.compression = fields.text();
  index.compressed_size = fields.number<u64>();
  index.uncompressed_size = fields.number<u64>();
  return if_sound(fields, std::move(index));
}

void append_attachment(std::string& out, const Attachment& attachment) {
  RecordBytes record(out, Opcode::attachment);
  record.number(attachment.log_time_ns).number(attachment.create_time_ns);
  record.text(attachment.name).text(attachment.media_type);
  record.number(static_cast<u64>(attachment.data.size())).bytes(attachment.data);
  record.number(crc32(std::string_view(out).substr(record.content_begin()))).finish();
}
std::optional<StoredAttachment> decode_attachment(std::string_view content) {
  Fields fields(content);
  StoredAttachment stored;
  auto& attachment = stored.attachment;
  attachment.log_time_ns = fields.number<u64>();
  attachment.create_time_ns = fields.number<u64>();
  attachment.name = fields.text();
  attachment.media_type = fields.text();
  attachment.data = fields.bytes(fields.number<u64>());
  const std::size_t covered = content.size() - fields.rest().size();
  const auto crc = fields.number<u32>();
  if (!fields.sound()) return std::nullopt;
  stored.crc_right = crc == 0 || crc == crc32(content.substr(0, covered));
  return stored;
}

void append_attachment_index(std::string& out, const AttachmentIndex& index) {
  RecordBytes record(out, Opcode::attachment_index);
  record.number(index.offset).number(index.length).number(index.log_time_ns).number(index.create_time_ns);
  record.number(index.data_size).text(index.name).text(index.media_type).finish();
}
std::optional<AttachmentIndex> decode_attachment_index(std::string_view content) {
  Fields fields(content);
  AttachmentIndex index;
  index.offset = fields.number<u64>();
  index.length = fields.number<u64>();
  index.log_time_ns = fields.number<u64>();
  index.create_time_ns = fields.number<u64>();
  index.data_size = fields.number<u64>();
  index.name = fields.text();
  index.media_type = fields.text();
  return if_sound(fields, std::move(index));
}

void append_metadata(std::string& out, const Metadata& metadata) {
  RecordBytes(out, Opcode::metadata).text(metadata.name).words(metadata.values).finish();
}
std::optional<Metadata> decode_metadata(std::string_view content) {
  Fields fields(content);
  Metadata metadata;
  metadata.name = fields.text();
  metadata.values = fields.words();
  return if_sound(fields, std::move(metadata));
}

void append_metadata_index(std::string& out, const MetadataIndex& index) {
  RecordBytes(out, Opcode::metadata_index)
      .number(index.offset)
      .number(index.length)
      .text(index.name)
      .finish();
}
std::optional<MetadataIndex> decode_metadata_index(std::string_view content) {
  Fields fields(content);
  MetadataIndex index;
  index.offset = fields.number<u64>();
  index.length = fields.number<u64>();
  index.name = fields.text();
  return if_sound(fields, std::move(index));
}

void append_statistics(std::string& out, const Statistics& statistics) {
  RecordBytes record(out, Opcode::statistics);
  record.number(statistics.messages).number(statistics.schemas).number(statistics.channels);
  record.number(statistics.attachments).number(statistics.metadata).number(statistics.chunks);
  record.number(statistics.start_ns).number(statistics.end_ns);
  add_numbers(record, statistics.messages_of_channels);
  record.finish();
}
std::optional<Statistics> decode_statistics(std::string_view content) {
  Fields fields(content);
  Statistics statistics;
  statistics.messages = fields.number<u64>();
  statistics.schemas = fields.number<u16>();
  statistics.channels = fields.number<u32>();
  statistics.attachments = fields.number<u32>();
  statistics.metadata = fields.number<u32>();
  statistics.chunks = fields.number<u32>();
  statistics.start_ns = fields.number<u64>();
  statistics.end_ns = fields.number<u64>();
  statistics.messages_of_channels = numbers_of(fields);
  return if_sound(fields, std::move(statistics));
}

void append_summary_offset(std::string& out, const SummaryOffset& offset) {
  RecordBytes record(out, Opcode::summary_offset);
  record.number(static_cast<std::uint8_t>(offset.group)).number(offset.start).number(offset.length).finish();
}
std::optional<SummaryOffset> decode_summary_offset(std::string_view content) {
  Fields fields(content);
  SummaryOffset offset;
  offset.group = static_cast<Opcode>(fields.number<std::uint8_t>());
  offset.start = fields.number<u64>();
  offset.length = fields.number<u64>();
  return if_sound(fields, offset);
}

void append_data_end(std::string& out, u32 data_crc) {
  RecordBytes(out, Opcode::data_end).number(data_crc).finish();
}

std::optional<Footer> decode_footer(std::string_view content) {
  Fields fields(content);
  Footer footer;
  footer.summary_start = fields.number<u64>();
  footer.summary_offset_start = fields.number<u64>();
  footer.summary_crc = fields.number<u32>();
  return if_sound(fields, footer);
}

}  // namespace palpate::record
