#include "palpate/record/mcap_writer.h"

#include <algorithm>
#include <limits>
#include <optional>
#include <stdexcept>
#include <utility>
#include <vector>

#include "palpate/core/text.h"
#include "palpate/record/internal/compression.h"
#include "palpate/record/internal/crc32.h"
#include "palpate/record/internal/mcap_records.h"
#include "palpate/record/internal/spilled_bytes.h"

namespace palpate::record {
namespace {

constexpr std::size_t kMostNumbers =
    std::numeric_limits<std::uint16_t>::max() - 1;  // of schemas, of channels

// The number of `value` in `list`, from 1 on; one behind the last where it is not there.
template <typename T>
std::size_t number_in(const std::vector<T>& list, const T& value) {
  return static_cast<std::size_t>(std::find(list.begin(), list.end(), value) - list.begin()) + 1;
}

}  // namespace

std::string own_library() { return "palpate " PALPATE_VERSION; }

struct McapWriter::State {
  struct OpenChunk {
    std::string records;
    std::uint64_t messages = 0, start_ns = 0, end_ns = 0, first_ns = 0;
    std::vector<Places> places;  // of each channel of the file
  };

  State(RecordFile to, WriterOptions how);
  Expected<std::uint16_t> add_schema(const Schema& schema);
  Expected<std::uint16_t> add_channel(const Channel& channel);
  Expected<void> write(const Message& message);
  Expected<void> attach(const Attachment& attachment);
  Expected<void> write(const Metadata& metadata);
  Expected<void> flush();
  Expected<void> sync() { return failed_ ? tl::unexpected(*failed_) : note(file_.sync()); }
  Expected<Statistics> close();
  Expected<void> note(Expected<void> done);
  Expected<void> put(const std::string& bytes);
  void tell_in_chunk(std::uint16_t channel);
  Expected<void> put_summary();
  Expected<void> put_chunk_indexes();

  RecordFile file_;
  WriterOptions options_;
  Compressor compressor_;
  std::optional<Error> failed_;
  std::uint32_t section_crc_ = 0;                 // of the data so far, then of the summary so far
  std::vector<Schema> schemas_;                   // number - 1
  std::vector<Channel> channels_;                 // number - 1
  std::vector<bool> schema_told_, channel_told_;  // in a chunk
  OpenChunk chunk_;
  SpilledBytes chunk_indexes_;  // as they will stand in the summary: some for each second of the recording
  std::vector<AttachmentIndex> attachment_indexes_;
  std::vector<MetadataIndex> metadata_indexes_;
  Statistics statistics_;
};

McapWriter::State::State(RecordFile to, WriterOptions how)
    : file_(std::move(to)),
      options_(std::move(how)),
      chunk_indexes_(file_.path().empty() ? FileDescriptor() : nameless_file(file_.path())) {
  if (options_.chunk_bytes > kMostMessageBytes)
    throw std::invalid_argument("McapWriter: chunks of more than 128 MiB are for no reader");
}

Expected<void> McapWriter::State::note(Expected<void> done) {
  if (!done) failed_ = done.error();
  return done;
}

Expected<void> McapWriter::State::put(const std::string& bytes) {
  if (failed_) return tl::unexpected(*failed_);
  section_crc_ = crc32(bytes, section_crc_);
  return note(file_.append(bytes));
}

Expected<std::uint16_t> McapWriter::State::add_schema(const Schema& schema) {
  const std::size_t number = number_in(schemas_, schema);
  if (number <= schemas_.size()) return static_cast<std::uint16_t>(number);
  if (schemas_.size() == kMostNumbers)
    return refused("{}: a recording holds at most {} schemas; record fewer streams", file_.name(),
                   kMostNumbers);
  std::string record;
  append_schema(record, static_cast<std::uint16_t>(number), schema);
  if (auto done = put(record); !done) return tl::unexpected(done.error());
  schemas_.push_back(schema);
  schema_told_.push_back(false);
  ++statistics_.schemas;
  return static_cast<std::uint16_t>(number);
}

Expected<std::uint16_t> McapWriter::State::add_channel(const Channel& channel) {
  if (channel.schema > schemas_.size())
    throw std::invalid_argument("McapWriter: a channel of a schema that was not added");
  const std::size_t number = number_in(channels_, channel);
  if (number <= channels_.size()) return static_cast<std::uint16_t>(number);
  if (channels_.size() == kMostNumbers)
    return refused("{}: a recording holds at most {} channels; record fewer streams", file_.name(),
                   kMostNumbers);
  std::string record;
  append_channel(record, static_cast<std::uint16_t>(number), channel);
  if (auto done = put(record); !done) return tl::unexpected(done.error());
  channels_.push_back(channel);
  channel_told_.push_back(false);
  chunk_.places.emplace_back();
  ++statistics_.channels;
  return static_cast<std::uint16_t>(number);
}

void McapWriter::State::tell_in_chunk(std::uint16_t channel) {
  if (channel_told_[channel - 1u]) return;
  channel_told_[channel - 1u] = true;
  const Channel& told = channels_[channel - 1u];
  if (told.schema != 0 && !schema_told_[told.schema - 1u]) {
    schema_told_[told.schema - 1u] = true;
    append_schema(chunk_.records, told.schema, schemas_[told.schema - 1u]);
  }
  append_channel(chunk_.records, channel, told);
}

Expected<void> McapWriter::State::write(const Message& message) {
  if (failed_) return tl::unexpected(*failed_);
  if (message.channel == 0 || message.channel > channels_.size())
    throw std::invalid_argument("McapWriter: a message of a channel that was not added");
  if (message.data.size() > kMostMessageBytes)
    return refused("{}: a message of {} bytes on '{}'; at most {} are expected", file_.name(),
                   message.data.size(), excerpt(channels_[message.channel - 1u].topic), kMostMessageBytes);
  const auto time = message.log_time_ns;
  const auto chunk_ns = static_cast<std::uint64_t>(options_.chunk_time.count());
  const bool old = chunk_.messages > 0 && time > chunk_.first_ns && time - chunk_.first_ns >= chunk_ns;
  const bool full = chunk_.messages > 0 && chunk_.records.size() + message.data.size() > options_.chunk_bytes;
  if (old || full)
    if (auto done = flush(); !done) return done;
  tell_in_chunk(message.channel);
  chunk_.places[message.channel - 1u].emplace_back(time, chunk_.records.size());
  append_message(chunk_.records, message);
  if (chunk_.messages == 0) chunk_.start_ns = chunk_.end_ns = chunk_.first_ns = time;
  chunk_.start_ns = std::min(chunk_.start_ns, time);
  chunk_.end_ns = std::max(chunk_.end_ns, time);
  ++chunk_.messages;
  if (statistics_.messages == 0) statistics_.start_ns = statistics_.end_ns = time;
  statistics_.start_ns = std::min(statistics_.start_ns, time);
  statistics_.end_ns = std::max(statistics_.end_ns, time);
  ++statistics_.messages;
  ++statistics_.messages_of_channels[message.channel];
  return chunk_.records.size() >= options_.chunk_bytes ? flush() : Expected<void>{};
}

Expected<void> McapWriter::State::flush() {
  if (failed_) return tl::unexpected(*failed_);
  if (chunk_.messages == 0) return {};
  ChunkHead head;
  head.start_ns = chunk_.start_ns;
  head.end_ns = chunk_.end_ns;
  head.uncompressed_size = chunk_.records.size();
  head.uncompressed_crc = crc32(chunk_.records);
  head.compression = options_.compress ? "zstd" : "";
  head.records = options_.compress ? compressor_.compress(chunk_.records) : chunk_.records;
  std::string out;
  append_chunk(out, head);
  ChunkIndex index{head.start_ns,    head.end_ns,         file_.size(),          out.size(), {}, 0,
                   head.compression, head.records.size(), head.uncompressed_size};
  for (std::size_t i = 0; i < chunk_.places.size(); ++i) {
    auto& places = chunk_.places[i];
    if (places.empty()) continue;
    const auto channel = static_cast<std::uint16_t>(i + 1);
    index.message_index_offsets[channel] = file_.size() + out.size();
    append_message_index(out, channel, places);
    places.clear();
  }
  index.message_index_length = out.size() - index.length;
  chunk_.records.clear();
  chunk_.messages = 0;
  if (auto done = put(out); !done) return done;
  ++statistics_.chunks;
  std::string record;
  append_chunk_index(record, index);
  if (const int error = chunk_indexes_.append(record); error != 0)
    return note(file_.failed("writing its index aside", error));
  return {};
}

Expected<void> McapWriter::State::attach(const Attachment& attachment) {
  if (attachment.data.size() > kMostAttachmentBytes)
    return refused("{}: an attachment '{}' of {} bytes; at most {} are expected", file_.name(),
                   excerpt(attachment.name), attachment.data.size(), kMostAttachmentBytes);
  std::string out;
  append_attachment(out, attachment);
  AttachmentIndex index{
      file_.size(),           out.size(),      attachment.log_time_ns, attachment.create_time_ns,
      attachment.data.size(), attachment.name, attachment.media_type};
  if (auto done = put(out); !done) return done;
  attachment_indexes_.push_back(std::move(index));
  ++statistics_.attachments;
  return {};
}

Expected<void> McapWriter::State::write(const Metadata& metadata) {
  std::string out;
  append_metadata(out, metadata);
  MetadataIndex index{file_.size(), out.size(), metadata.name};
  if (auto done = put(out); !done) return done;
  metadata_indexes_.push_back(std::move(index));
  ++statistics_.metadata;
  return {};
}

Expected<void> McapWriter::State::put_chunk_indexes() {
  std::string part;
  for (std::uint64_t at = 0; at < chunk_indexes_.size(); at += part.size()) {
    if (const int error = chunk_indexes_.read(at, part); error != 0)
      return note(file_.failed("reading its index", error));
    if (auto done = put(part); !done) return done;
  }
  return {};
}

// All records of it with the footer, whose CRC covers them.
Expected<void> McapWriter::State::put_summary() {
  std::string out;
  std::vector<SummaryOffset> groups;
  const std::uint64_t begin = file_.size();
  const auto here = [&] { return file_.size() + out.size(); };
  const auto group = [&](Opcode opcode, const auto& add) {
    const std::uint64_t before = here();
    add();
    if (here() > before) groups.push_back({opcode, before, here() - before});
  };
  group(Opcode::schema, [&] {
    for (std::size_t i = 0; i < schemas_.size(); ++i)
      append_schema(out, static_cast<std::uint16_t>(i + 1), schemas_[i]);
  });
  group(Opcode::channel, [&] {
    for (std::size_t i = 0; i < channels_.size(); ++i)
      append_channel(out, static_cast<std::uint16_t>(i + 1), channels_[i]);
  });
  group(Opcode::statistics, [&] { append_statistics(out, statistics_); });
  if (auto done = put(std::exchange(out, {})); !done) return done;
  Expected<void> copied;
  group(Opcode::chunk_index, [&] { copied = put_chunk_indexes(); });
  if (!copied) return copied;
  group(Opcode::attachment_index, [&] {
    for (const auto& index : attachment_indexes_) append_attachment_index(out, index);
  });
  group(Opcode::metadata_index, [&] {
    for (const auto& index : metadata_indexes_) append_metadata_index(out, index);
  });
  const std::uint64_t offsets_begin = here();
  for (const auto& offset : groups) append_summary_offset(out, offset);
  RecordBytes footer(out, Opcode::footer);
  footer.number(begin).number(offsets_begin);
  // The footer's length is among what the CRC covers: entered first, then the CRC behind it.
  const std::size_t crc_at = out.size();
  footer.number(std::uint32_t{0}).finish();
  out.resize(crc_at);
  append_little_endian(out, crc32(out, section_crc_));
  out += kMagic;
  return put(out);
}

Expected<Statistics> McapWriter::State::close() {
  if (auto done = flush(); !done) return tl::unexpected(done.error());
  std::string data_end;
  append_data_end(data_end, section_crc_);
  if (auto done = put(data_end); !done) return tl::unexpected(done.error());
  section_crc_ = 0;
  const std::uint64_t data_bytes = file_.size();
  if (auto done = put_summary(); !done) {
    file_.cut_back(data_bytes);  // half a summary is of no use, and a reader would count it as lost
    return tl::unexpected(done.error());
  }
  if (auto done = note(file_.finish()); !done) return tl::unexpected(done.error());
  return statistics_;
}

McapWriter::McapWriter(std::unique_ptr<State> state) : state_(std::move(state)) {}
McapWriter::~McapWriter() = default;
McapWriter::McapWriter(McapWriter&&) noexcept = default;
McapWriter& McapWriter::operator=(McapWriter&&) noexcept = default;

Expected<McapWriter> McapWriter::begin(RecordFile file, WriterOptions options) {
  auto state = std::make_unique<State>(std::move(file), std::move(options));
  std::string head(kMagic);
  append_header(head, state->options_.header);
  if (auto done = state->put(head); !done) return tl::unexpected(done.error());
  return McapWriter(std::move(state));
}

Expected<std::uint16_t> McapWriter::add_schema(const Schema& schema) { return state_->add_schema(schema); }
Expected<std::uint16_t> McapWriter::add_channel(const Channel& channel) {
  return state_->add_channel(channel);
}
Expected<void> McapWriter::write(const Message& message) { return state_->write(message); }
Expected<void> McapWriter::attach(const Attachment& attachment) { return state_->attach(attachment); }
Expected<void> McapWriter::write(const Metadata& metadata) { return state_->write(metadata); }
Expected<void> McapWriter::flush() { return state_->flush(); }
Expected<void> McapWriter::sync() { return state_->sync(); }
Expected<Statistics> McapWriter::close() { return state_->close(); }
const Statistics& McapWriter::statistics() const { return state_->statistics_; }
std::uint64_t McapWriter::file_bytes() const { return state_->file_.size(); }

}  // namespace palpate::record
