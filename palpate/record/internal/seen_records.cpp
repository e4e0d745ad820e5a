#include "palpate/record/internal/seen_records.h"

#include <fmt/format.h>

#include <algorithm>
#include <tuple>
#include <utility>

#include "palpate/core/text.h"

namespace palpate::record {
namespace {

constexpr std::uint64_t kMostDefinitionBytes = 64 * 1024 * 1024;
constexpr std::size_t kMostIndexed =
    4'000'000;  // chunks, attachments or metadata: three weeks at two chunks a second

constexpr const char* kTooShort = "its fields do not fit it";

// An index record that has to be the same as what was seen at its offset.
template <typename Index>
Complaint check_index(const std::optional<Index>& told, const std::map<std::uint64_t, Index>& seen,
                      std::uint64_t& count) {
  if (!told) return kTooShort;
  ++count;
  const auto found = seen.find(told->offset);
  if (found == seen.end()) return fmt::format("nothing it could mean is at byte {}", told->offset);
  if (!(found->second == *told)) return fmt::format("differs from what is at byte {}", told->offset);
  return "";
}

std::map<std::uint16_t, std::uint64_t> without_zeros(std::map<std::uint16_t, std::uint64_t> counts) {
  std::erase_if(counts, [](const auto& entry) { return entry.second == 0; });
  return counts;
}

}  // namespace

template <typename T>
Complaint SeenRecords::define(std::map<std::uint16_t, T>& known, std::uint16_t number, T&& told, bool trusted,
                              const char* what) {
  const auto found = known.find(number);
  if (found == known.end()) {
    known.emplace(number, std::move(told));
    return "";
  }
  if (found->second == told) return "";
  if (trusted) found->second = std::move(told);
  return fmt::format("tells of {} {} in another way than before", what, number);
}

Complaint SeenRecords::define_schema(std::string_view content, bool trusted) {
  auto told = decode_schema(content);
  if (!told) return kTooShort;
  if (!schemas_.count(told->first)) definition_bytes_ += content.size();
  if (definition_bytes_ > kMostDefinitionBytes)
    return "too many schemas and channels; at most 64 MiB are expected";
  return define(schemas_, told->first, std::move(told->second), trusted, "schema");
}

Complaint SeenRecords::define_channel(std::string_view content, bool trusted) {
  auto told = decode_channel(content);
  if (!told) return kTooShort;
  if (!channels_.count(told->first)) definition_bytes_ += content.size();
  if (definition_bytes_ > kMostDefinitionBytes)
    return "too many schemas and channels; at most 64 MiB are expected";
  const auto schema = told->second.schema;
  if (schema != 0 && !schemas_.count(schema))
    return fmt::format("names schema {}, of which nothing was told", schema);
  return define(channels_, told->first, std::move(told->second), trusted, "channel");
}

const Channel* SeenRecords::channel(std::uint16_t number) const {
  const auto found = channels_.find(number);
  return found == channels_.end() ? nullptr : &found->second;
}

const Schema* SeenRecords::schema(std::uint16_t number) const {
  const auto found = schemas_.find(number);
  return found == schemas_.end() ? nullptr : &found->second;
}

void SeenRecords::begin_chunk(const ChunkHead& head, std::uint64_t offset, std::uint64_t length) {
  places_.clear();
  chunk_messages_ = 0;
  ++statistics_.chunks;
  before_ = chunks_.size() < kMostIndexed ? Before::sound : Before::damaged;
  if (before_ != Before::sound) return;
  chunks_.emplace(offset, ChunkIndex{head.start_ns,
                                     head.end_ns,
                                     offset,
                                     length,
                                     {},
                                     0,
                                     head.compression,
                                     head.records.size(),
                                     head.uncompressed_size});
}

void SeenRecords::add_message(const Message& message, std::optional<std::uint64_t> place) {
  const auto time = message.log_time_ns;
  if (place) {
    places_[message.channel].emplace_back(time, *place);
    if (chunk_messages_++ == 0) chunk_start_ns_ = chunk_end_ns_ = time;
    chunk_start_ns_ = std::min(chunk_start_ns_, time);
    chunk_end_ns_ = std::max(chunk_end_ns_, time);
  }
  if (statistics_.messages++ == 0) statistics_.start_ns = statistics_.end_ns = time;
  statistics_.start_ns = std::min(statistics_.start_ns, time);
  statistics_.end_ns = std::max(statistics_.end_ns, time);
  ++statistics_.messages_of_channels[message.channel];
}

Complaint SeenRecords::end_chunk(const ChunkHead& head) const {
  if (chunk_messages_ == 0 || (head.start_ns == chunk_start_ns_ && head.end_ns == chunk_end_ns_)) return "";
  return fmt::format("says that its messages are from {} to {} ns; they are from {} to {} ns", head.start_ns,
                     head.end_ns, chunk_start_ns_, chunk_end_ns_);
}

Complaint SeenRecords::add_message_index(std::string_view content, std::uint64_t offset,
                                         std::uint64_t length) {
  auto index = decode_message_index(content);
  if (!index) return kTooShort;
  if (before_ == Before::other) return "stands behind no chunk";
  if (before_ == Before::damaged) return "";  // which has been told
  auto& chunk = chunks_.rbegin()->second;
  chunk.message_index_offsets[index->channel] = offset;
  chunk.message_index_length += length;
  auto& places = places_[index->channel];
  // Sizes first: a file of many small indexes of a large chunk costs no more than it is long.
  if (places.size() == index->places.size()) {
    std::sort(places.begin(), places.end());
    std::sort(index->places.begin(), index->places.end());
    if (places == index->places) return "";
  }
  return fmt::format("of channel {} differs from the messages of the chunk before it", index->channel);
}

void SeenRecords::add_attachment(AttachmentIndex index) {
  leave_chunk();
  ++statistics_.attachments;
  if (attachments_.size() < kMostIndexed) attachments_.emplace(index.offset, std::move(index));
}

void SeenRecords::add_metadata(MetadataIndex index) {
  leave_chunk();
  ++statistics_.metadata;
  if (metadata_.size() < kMostIndexed) metadata_.emplace(index.offset, std::move(index));
}

Complaint SeenRecords::check_chunk_index(std::string_view content) {
  const auto told = decode_chunk_index(content);
  if (!told) return kTooShort;
  ++chunk_indexes_;
  const auto found = chunks_.find(told->offset);
  if (found == chunks_.end() && chunks_.size() == kMostIndexed) return "";  // not kept any more
  if (found == chunks_.end()) return fmt::format("no chunk is at byte {}", told->offset);
  const auto& seen = found->second;
  // Some writers leave out indexes that hold nothing.
  for (const auto& [channel, offset] : told->message_index_offsets) {
    const auto index = seen.message_index_offsets.find(channel);
    if (index == seen.message_index_offsets.end() || index->second != offset)
      return fmt::format("no index of channel {} is at byte {}", channel, offset);
  }
  const auto numbers = [](const ChunkIndex& of) {
    return std::tuple(of.start_ns, of.end_ns, of.length, of.message_index_length, of.compressed_size,
                      of.uncompressed_size);
  };
  const bool same = numbers(seen) == numbers(*told) && seen.compression == told->compression;
  return same ? "" : fmt::format("differs from the chunk at byte {}", told->offset);
}

Complaint SeenRecords::check_statistics(std::string_view content) const {
  const auto told = decode_statistics(content);
  if (!told) return kTooShort;
  const auto differs = [](const char* what, std::uint64_t says, std::uint64_t is) {
    return says == is ? Complaint() : fmt::format("counts {} {}, there are {}", says, what, is);
  };
  for (const auto& complaint : {differs("messages", told->messages, statistics_.messages),
                                differs("chunks", told->chunks, statistics_.chunks),
                                differs("attachments", told->attachments, statistics_.attachments),
                                differs("metadata", told->metadata, statistics_.metadata),
                                differs("schemas", told->schemas, schemas_.size()),
                                differs("channels", told->channels, channels_.size())})
    if (!complaint.empty()) return complaint;
  if (told->start_ns != statistics_.start_ns || told->end_ns != statistics_.end_ns)
    return fmt::format("says that messages are from {} to {} ns; they are from {} to {} ns", told->start_ns,
                       told->end_ns, statistics_.start_ns, statistics_.end_ns);
  if (without_zeros(told->messages_of_channels) != statistics_.messages_of_channels)
    return "counts other numbers of messages for the channels than there are";
  return "";
}

Complaint SeenRecords::check_summary_offset(std::string_view content) const {
  const auto told = decode_summary_offset(content);
  if (!told) return kTooShort;
  const auto found = groups_.find(told->group);
  if (found != groups_.end() && found->second.start == told->start && found->second.length == told->length)
    return "";
  return fmt::format("no group of {} is where it says", name_of(told->group));
}

Complaint SeenRecords::check_summary_record(Opcode opcode, std::string_view content, std::uint64_t offset,
                                            std::uint64_t length) {
  auto& group = groups_.emplace(opcode, Group{offset, 0}).first->second;
  group.length += length;
  switch (opcode) {
    case Opcode::schema:
      return define_schema(content, false);
    case Opcode::channel:
      return define_channel(content, false);
    case Opcode::statistics:
      return check_statistics(content);
    case Opcode::chunk_index:
      return check_chunk_index(content);
    case Opcode::attachment_index:
      return check_index(decode_attachment_index(content), attachments_, attachment_indexes_);
    case Opcode::metadata_index:
      return check_index(decode_metadata_index(content), metadata_, metadata_indexes_);
    case Opcode::summary_offset:
      return check_summary_offset(content);
    default:
      return static_cast<unsigned>(opcode) > static_cast<unsigned>(Opcode::data_end)
                 ? ""
                 : fmt::format("{} has no place in a summary", name_of(opcode));
  }
}

Complaint SeenRecords::check_summary_end() const {
  // None at all is fine: then the file has no index of them.
  const auto differs = [](const char* what, std::uint64_t told, std::uint64_t seen) {
    return told == 0 || told == seen ? Complaint() : fmt::format("lists {} of {} {}", told, seen, what);
  };
  for (const auto& complaint : {differs("chunks", chunk_indexes_, statistics_.chunks),
                                differs("attachments", attachment_indexes_, statistics_.attachments),
                                differs("metadata", metadata_indexes_, statistics_.metadata)})
    if (!complaint.empty()) return complaint;
  return "";
}

}  // namespace palpate::record
