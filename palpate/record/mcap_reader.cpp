#include "palpate/record/mcap_reader.h"

#include <algorithm>
#include <optional>
#include <utility>

#include "palpate/record/internal/chunk_search.h"
#include "palpate/record/internal/chunk_unpacker.h"
#include "palpate/record/internal/crc32.h"
#include "palpate/record/internal/mcap_records.h"
#include "palpate/record/internal/seen_records.h"
#include "palpate/record/internal/source_window.h"

namespace palpate::record {
namespace {

constexpr std::size_t kMostFaults = 100;  // that are kept
constexpr std::uint64_t kMostRecordBytes = kMostAttachmentBytes + 1024 * 1024;
constexpr std::size_t kPassedAtOnce = 256 * 1024;  // of what is only passed over
constexpr std::uint64_t kLongestChunkNs =
    3'600'000'000'000;  // of log time, where one that is cut is believed

struct Record {
  Opcode opcode = Opcode::none;
  std::uint64_t offset = 0, length = 0;  // of the file; with opcode and length
  std::string_view bytes;                // all of it
  std::string_view content() const { return bytes.substr(kRecordHeadBytes); }
};

// Goes through one file once.
class Scanner {
 public:
  Scanner(ByteSource& source, const ScanOptions& options, ScanHandler& handler)
      : options_(options),
        handler_(handler),
        window_(source),
        size_(source.size()),
        unpacker_(source.name(), options.most_chunk_bytes),
        search_(window_, unpacker_, size_, kMostRecordBytes) {}
  Expected<ScanResult> run();

 private:
  enum class Next : std::uint8_t { record, end };  // `end`: of what can be read of this section
  Expected<Next> next(Record& record);
  Expected<Next> lost_from(std::uint64_t offset, std::string words);
  Expected<void> pass_over(std::uint64_t offset, std::uint64_t length);
  Expected<void> cut_off(std::uint64_t offset);
  Expected<void> begin();
  Expected<void> data_section();
  Expected<void> data_record(const Record& record);
  Expected<void> summary();
  Expected<void> read_chunk(const Record& record);
  Expected<void> read_chunk_records(std::string_view records, const ChunkHead& head,
                                    std::uint64_t chunk_offset);
  Expected<void> read_message(std::string_view content, std::optional<std::uint64_t> place,
                              std::uint64_t offset);
  Expected<void> read_attachment(const Record& record);
  Expected<void> read_metadata(const Record& record);
  bool wanted(const Message& message, const Channel& channel) const;
  void sound_time(std::uint64_t time_ns);
  void lost_times(std::uint64_t start_ns, std::uint64_t end_ns);
  void damaged(const Record& record, std::string words);
  void fault(std::uint64_t offset, std::string words);
  void complain(std::uint64_t offset, Opcode opcode, const Complaint& complaint) {
    if (!complaint.empty()) fault(offset, name_of(opcode) + ": " + complaint);
  }
  bool stopped() const { return !options_.tolerant && result_.fault_count > 0; }

  const ScanOptions& options_;
  ScanHandler& handler_;
  SourceWindow window_;
  const std::uint64_t size_;
  ChunkUnpacker unpacker_;
  ChunkSearch search_;
  std::uint64_t at_ = 0;
  std::uint32_t data_crc_ = 0;
  bool data_crc_known_ = true;  // no byte of the data section was left out
  bool data_ended_ = false, ended_ = false;
  bool over_ = false;                     // nothing in it can be read
  std::optional<std::uint64_t> last_ns_;  // the latest log time of a sound message
  bool gap_ = false;                      // something was lost since
  std::uint64_t lost_until_ns_ = 0;       // as far as what was lost tells
  SeenRecords seen_;
  ScanResult result_;
};

void Scanner::fault(std::uint64_t offset, std::string words) {
  if (stopped()) return;
  if (result_.faults.size() < kMostFaults) result_.faults.push_back({offset, std::move(words)});
  ++result_.fault_count;
}

void Scanner::damaged(const Record& record, std::string words) {
  fault(record.offset, name_of(record.opcode) + ": " + std::move(words));
  result_.lost_bytes += record.length;
  if (record.opcode == Opcode::chunk) ++result_.lost_chunks;
  if (record.opcode == Opcode::chunk || record.opcode == Opcode::message) gap_ = true;
  seen_.forget_chunk();
}

// A message is sound; what was lost before it lay in between.
void Scanner::sound_time(std::uint64_t time_ns) {
  if (gap_ && last_ns_ && time_ns > *last_ns_)
    result_.lost_s += 1e-9 * static_cast<double>(time_ns - *last_ns_);
  gap_ = false;
  last_ns_ = std::max(last_ns_.value_or(time_ns), time_ns);
}

// A chunk that is damaged or cut off says from when to when its messages were. No CRC covers that: believed where it may be.
void Scanner::lost_times(std::uint64_t start_ns, std::uint64_t end_ns) {
  if (start_ns > end_ns || end_ns - start_ns > kLongestChunkNs) return;
  if (!last_ns_) last_ns_ = start_ns;
  const auto before = *last_ns_;
  if ((start_ns > before ? start_ns - before : before - start_ns) <= kLongestChunkNs)
    lost_until_ns_ = std::max(lost_until_ns_, end_ns);
}

// Reads and sums up what is not looked at.
Expected<void> Scanner::pass_over(std::uint64_t offset, std::uint64_t length) {
  while (length > 0) {
    const auto part = static_cast<std::size_t>(std::min<std::uint64_t>(length, kPassedAtOnce));
    const auto bytes = window_.view(offset, part);
    if (!bytes) return tl::unexpected(bytes.error());
    data_crc_ = crc32(*bytes, data_crc_);
    offset += part;
    length -= part;
  }
  return {};
}

// The record at at_, which moves on behind it. Its CRC is not summed up yet.
Expected<Scanner::Next> Scanner::next(Record& record) {
  for (;;) {
    if (size_ - at_ < kRecordHeadBytes) {
      if (auto done = cut_off(at_); !done) return tl::unexpected(done.error());
      return Next::end;
    }
    const auto head = window_.view(at_, kRecordHeadBytes);
    if (!head) return tl::unexpected(head.error());
    record.opcode = static_cast<Opcode>(static_cast<unsigned char>(head->front()));
    const auto length = little_endian<std::uint64_t>(head->data() + 1);
    record.offset = at_;
    const bool fits = length <= size_ - at_ - kRecordHeadBytes;
    if (record.opcode == Opcode::none || !fits) {
      auto words =
          record.opcode == Opcode::none
              ? std::string("no record begins with a zero")
              : fmt::format(
                    "{}: says that it has {} bytes, the file has {} from here on; it is cut off or damaged",
                    name_of(record.opcode), length, size_ - at_ - kRecordHeadBytes);
      auto found = lost_from(at_, std::move(words));
      if (!found || *found == Next::end) return found;
      continue;
    }
    record.length = kRecordHeadBytes + length;
    at_ += record.length;
    const bool known = record.opcode <= Opcode::data_end;
    if (!known || record.length > kMostRecordBytes) {
      if (auto done = pass_over(record.offset, record.length); !done) return tl::unexpected(done.error());
      if (known)
        damaged(record, fmt::format("has {} bytes; at most {} are expected", length, kMostRecordBytes));
      if (stopped()) return Next::end;
      continue;
    }
    const auto bytes = window_.view(record.offset, static_cast<std::size_t>(record.length));
    if (!bytes) return tl::unexpected(bytes.error());
    record.bytes = *bytes;
    return Next::record;
  }
}

// The file is over, and what should be at its end is not there.
Expected<void> Scanner::cut_off(std::uint64_t offset) {
  result_.lost_bytes += size_ - offset;
  fault(offset, data_ended_ ? "the file ends within its summary"
                            : "the file ends without DataEnd: its writer was ended, or the file was cut off");
  at_ = size_;
  return {};
}

// Nothing tells where the record behind the one at `offset` begins: on to the next chunk that is sound.
Expected<Scanner::Next> Scanner::lost_from(std::uint64_t offset, std::string words) {
  fault(offset, std::move(words));
  if (stopped() || data_ended_) return Next::end;
  constexpr std::size_t kTimes = kRecordHeadBytes + 16;
  if (size_ - offset >= kTimes) {
    const auto bytes = window_.view(offset, kTimes);
    if (!bytes) return tl::unexpected(bytes.error());
    if (bytes->front() == static_cast<char>(Opcode::chunk))
      lost_times(little_endian<std::uint64_t>(bytes->data() + kRecordHeadBytes),
                 little_endian<std::uint64_t>(bytes->data() + kRecordHeadBytes + 8));
  }
  seen_.forget_chunk();
  gap_ = true;
  data_crc_known_ = false;
  const auto found = search_.first_from(offset + 1);
  if (!found) return tl::unexpected(found.error());
  result_.lost_bytes += found->value_or(size_) - offset;
  at_ = found->value_or(size_);
  return *found ? Next::record : Next::end;
}

Expected<void> Scanner::begin() {
  std::string_view magic;
  if (size_ >= kMagic.size()) {
    const auto bytes = window_.view(0, kMagic.size());
    if (!bytes) return tl::unexpected(bytes.error());
    magic = *bytes;
  }
  if (magic != kMagic) {
    const auto found = lost_from(0, "does not begin as a recording in MCAP does");
    if (!found) return tl::unexpected(found.error());
    over_ = *found == Next::end;
    return {};
  }
  at_ = kMagic.size();
  data_crc_ = crc32(magic);
  return {};
}

Expected<void> Scanner::data_section() {
  bool first = true;
  while (at_ < size_ || !data_ended_) {
    if (stopped()) return {};
    Record record;
    const auto found = next(record);
    if (!found) return tl::unexpected(found.error());
    if (*found == Next::end) return {};
    if (first && data_crc_known_ && record.opcode != Opcode::header)
      fault(record.offset, name_of(record.opcode) + ": a Header is expected before it");
    first = false;
    if (stopped()) return {};
    if (record.opcode == Opcode::data_end) {
      Fields fields(record.content());
      const auto crc = fields.number<std::uint32_t>();
      data_ended_ = true;
      if (!fields.sound())
        fault(record.offset, "DataEnd: its fields do not fit it");
      else if (crc != 0 && data_crc_known_ && crc != data_crc_)
        fault(record.offset, "DataEnd: the CRC of all before it is wrong");
      return {};
    }
    data_crc_ = crc32(record.bytes, data_crc_);
    if (auto done = data_record(record); !done) return done;
  }
  return {};
}

Expected<void> Scanner::data_record(const Record& record) {
  switch (record.opcode) {
    case Opcode::header: {
      auto header = decode_header(record.content());
      if (!header) damaged(record, "its fields do not fit it");
      if (header) result_.header = std::move(*header);
      return {};
    }
    case Opcode::schema:
      complain(record.offset, record.opcode, seen_.define_schema(record.content(), false));
      return {};
    case Opcode::channel:
      complain(record.offset, record.opcode, seen_.define_channel(record.content(), false));
      return {};
    case Opcode::message:
      // Rather a damaged record: nobody writes both, and no CRC covers it before the end.
      if (seen_.any_chunk()) {
        damaged(record, "stands outside of the chunks of a file that has chunks");
        return {};
      }
      seen_.leave_chunk();
      return read_message(record.content(), std::nullopt, record.offset);
    case Opcode::chunk:
      return read_chunk(record);
    case Opcode::message_index:
      complain(record.offset, record.opcode,
               seen_.add_message_index(record.content(), record.offset, record.length));
      return {};
    case Opcode::attachment:
      return read_attachment(record);
    case Opcode::metadata:
      return read_metadata(record);
    default:
      fault(record.offset, name_of(record.opcode) + ": has no place among the data");
      return {};
  }
}

Expected<void> Scanner::read_attachment(const Record& record) {
  const auto stored = decode_attachment(record.content());
  if (!stored || !stored->crc_right) {
    damaged(record, stored ? "its CRC is wrong" : "its fields do not fit it");
    return {};
  }
  const auto& attachment = stored->attachment;
  seen_.add_attachment({record.offset, record.length, attachment.log_time_ns, attachment.create_time_ns,
                        attachment.data.size(), attachment.name, attachment.media_type});
  return handler_.attachment(attachment);
}

Expected<void> Scanner::read_metadata(const Record& record) {
  const auto metadata = decode_metadata(record.content());
  if (!metadata) {
    damaged(record, "its fields do not fit it");
    return {};
  }
  seen_.add_metadata({record.offset, record.length, metadata->name});
  return handler_.metadata(*metadata);
}

Expected<void> Scanner::read_chunk(const Record& record) {
  const auto head = decode_chunk(record.content());
  if (!head) {
    damaged(record, "its fields do not fit it");
    return {};
  }
  std::string why;
  const auto records = unpacker_.unpack(*head, why);
  if (!records) return tl::unexpected(records.error());
  if (!*records) {
    damaged(record, std::move(why));
    lost_times(head->start_ns, head->end_ns);
    return {};
  }
  seen_.begin_chunk(*head, record.offset, record.length);
  if (auto done = read_chunk_records(**records, *head, record.offset); !done) return done;
  complain(record.offset, record.opcode, seen_.end_chunk(*head));
  return {};
}

Expected<void> Scanner::read_chunk_records(std::string_view records, const ChunkHead& head,
                                           std::uint64_t chunk_offset) {
  const bool trusted = head.uncompressed_crc != 0;
  for (std::uint64_t place = 0; place < records.size();) {
    Fields fields(records.substr(place));
    const auto opcode = static_cast<Opcode>(fields.number<std::uint8_t>());
    const auto content = fields.bytes(fields.number<std::uint64_t>());
    if (!fields.sound() || opcode == Opcode::none) {
      fault(chunk_offset, fmt::format("Chunk: no whole record is at byte {} of what it holds", place));
      result_.lost_bytes += records.size() - place;
      gap_ = true;
      return {};
    }
    if (opcode == Opcode::schema) {
      complain(chunk_offset, opcode, seen_.define_schema(content, trusted));
    } else if (opcode == Opcode::channel) {
      complain(chunk_offset, opcode, seen_.define_channel(content, trusted));
    } else if (opcode == Opcode::message) {
      if (auto done = read_message(content, place, chunk_offset); !done) return done;
    } else if (opcode <= Opcode::data_end) {
      fault(chunk_offset, name_of(opcode) + ": has no place in a chunk");
    }
    if (stopped()) return {};
    place += kRecordHeadBytes + content.size();
  }
  return {};
}

bool Scanner::wanted(const Message& message, const Channel& channel) const {
  return message.log_time_ns >= options_.from_ns && message.log_time_ns <= options_.to_ns &&
         (options_.topics.empty() ||
          std::find(options_.topics.begin(), options_.topics.end(), channel.topic) != options_.topics.end());
}

Expected<void> Scanner::read_message(std::string_view content, std::optional<std::uint64_t> place,
                                     std::uint64_t offset) {
  const auto message = decode_message(content);
  const Channel* channel = message ? seen_.channel(message->channel) : nullptr;
  if (channel == nullptr) {
    fault(offset, message ? fmt::format("Message: of channel {}, of which nothing was told", message->channel)
                          : "Message: its fields do not fit it");
    result_.lost_bytes += kRecordHeadBytes + content.size();
    gap_ = true;
    return {};
  }
  sound_time(message->log_time_ns);
  seen_.add_message(*message, place);
  if (!wanted(*message, *channel)) return {};
  return handler_.message({*message, *channel, seen_.schema(channel->schema)});
}

Expected<void> Scanner::summary() {
  const std::uint64_t begin = at_;
  std::uint32_t crc = 0;
  while (!stopped()) {
    const auto before = at_;
    Record record;
    data_crc_ = crc;  // what is passed over is summed up there
    const auto found = next(record);
    if (!found) return tl::unexpected(found.error());
    if (*found == Next::end) return {};
    if (record.offset != before) crc = data_crc_;
    if (record.opcode == Opcode::footer) {
      const auto footer = decode_footer(record.content());
      const auto covered = crc32(record.bytes.substr(0, kRecordHeadBytes + kFooterBytesBeforeCrc), crc);
      if (!footer || record.length != kRecordHeadBytes + kFooterBytes) {
        fault(record.offset, "Footer: has another length than its fields");
        return {};
      }
      const bool none = footer->summary_start == 0 && record.offset == begin;
      if (!none && footer->summary_start != begin)
        fault(record.offset, fmt::format("Footer: says that the summary begins at byte {}; it does at {}",
                                         footer->summary_start, begin));
      if (footer->summary_crc != 0 && footer->summary_crc != covered)
        fault(record.offset, "Footer: the CRC of the summary is wrong");
      complain(record.offset, record.opcode, result_.fault_count == 0 ? seen_.check_summary_end() : "");
      ended_ = true;
      return {};
    }
    crc = crc32(record.bytes, crc);
    // After a fault the summary of what was there differs from what is left.
    if (result_.fault_count == 0)
      complain(record.offset, record.opcode,
               seen_.check_summary_record(record.opcode, record.content(), record.offset, record.length));
  }
  return {};
}

Expected<ScanResult> Scanner::run() {
  if (auto done = begin(); !done) return tl::unexpected(done.error());
  if (!stopped() && !over_)
    if (auto done = data_section(); !done) return tl::unexpected(done.error());
  if (data_ended_ && !stopped())
    if (auto done = summary(); !done) return tl::unexpected(done.error());
  if (ended_) {
    const auto left = std::min<std::uint64_t>(size_ - at_, kMagic.size());
    const auto bytes = window_.view(at_, static_cast<std::size_t>(left));
    if (!bytes) return tl::unexpected(bytes.error());
    if (*bytes != kMagic)
      fault(at_, "the file does not end as a recording in MCAP does");
    else if (size_ - at_ > kMagic.size())
      fault(at_ + kMagic.size(), "something stands behind the end of the recording");
  }
  if (gap_ && lost_until_ns_ > 0) sound_time(lost_until_ns_);
  result_.found = seen_.statistics();
  result_.complete = ended_ && result_.fault_count == 0;
  return std::move(result_);
}

}  // namespace

Expected<ScanResult> scan(ByteSource& source, const ScanOptions& options, ScanHandler& handler) {
  return Scanner(source, options, handler).run();
}

Expected<void> check_is_recording(const ScanResult& scanned, const std::string& name) {
  const bool foreign = !scanned.faults.empty() && scanned.faults.front().offset == 0;
  if (!foreign || scanned.found.messages != 0) return {};
  return wrong_use("{}: is no recording in MCAP; palpate record writes one", name);
}

}  // namespace palpate::record
