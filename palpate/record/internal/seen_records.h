// What a scan has seen in the data section of a recording, and how the summary of the same file compares with it. One thread.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "palpate/record/internal/mcap_records.h"
#include "palpate/record/mcap.h"

namespace palpate::record {

// What is wrong, without its offset; empty: nothing.
using Complaint = std::string;

class SeenRecords {
 public:
  // A schema or channel as a record tells of it. A second telling that differs is a complaint; it counts where it can be
  // trusted, because a CRC covers it.
  Complaint define_schema(std::string_view content, bool trusted);
  Complaint define_channel(std::string_view content, bool trusted);
  const Channel* channel(std::uint16_t number) const;
  const Schema* schema(std::uint16_t number) const;

  void begin_chunk(const ChunkHead& head, std::uint64_t offset, std::uint64_t length);
  void forget_chunk() { places_.clear(), before_ = Before::damaged; }  // of one that is damaged
  void leave_chunk() { places_.clear(), before_ = Before::other; }     // for what no index belongs to
  // A message that is sound; `place` within the unpacked chunk, none of one outside of all chunks.
  void add_message(const Message& message, std::optional<std::uint64_t> place);
  Complaint end_chunk(const ChunkHead& head) const;  // its times
  // Of the chunk before it.
  Complaint add_message_index(std::string_view content, std::uint64_t offset, std::uint64_t length);
  void add_attachment(AttachmentIndex index);
  void add_metadata(MetadataIndex index);

  // A record of the summary.
  Complaint check_summary_record(Opcode opcode, std::string_view content, std::uint64_t offset,
                                 std::uint64_t length);
  // Once all of them have been seen: what is missing.
  Complaint check_summary_end() const;

  Statistics statistics() const {
    Statistics all = statistics_;
    all.schemas = static_cast<std::uint16_t>(schemas_.size());
    all.channels = static_cast<std::uint32_t>(channels_.size());
    return all;
  }
  bool any_chunk() const { return statistics_.chunks > 0; }

 private:
  Complaint check_chunk_index(std::string_view content);
  Complaint check_statistics(std::string_view content) const;
  Complaint check_summary_offset(std::string_view content) const;
  template <typename T>
  Complaint define(std::map<std::uint16_t, T>& known, std::uint16_t number, T&& told, bool trusted,
                   const char* what);
  struct Group {
    std::uint64_t start = 0, length = 0;
  };

  std::map<std::uint16_t, Schema> schemas_;
  std::map<std::uint16_t, Channel> channels_;
  std::uint64_t definition_bytes_ = 0;
  enum class Before : std::uint8_t {
    other,
    sound,
    damaged
  };  // the last chunk, as long as its indexes may follow
  Before before_ = Before::other;
  std::uint64_t chunk_messages_ = 0, chunk_start_ns_ = 0, chunk_end_ns_ = 0;
  std::map<std::uint16_t, Places> places_;                // of the messages of the last chunk
  std::map<std::uint64_t, ChunkIndex> chunks_;            // by offset
  std::map<std::uint64_t, AttachmentIndex> attachments_;  // by offset
  std::map<std::uint64_t, MetadataIndex> metadata_;       // by offset
  Statistics statistics_;                                 // without schemas and channels
  std::map<Opcode, Group> groups_;                        // of the summary
  std::uint64_t chunk_indexes_ = 0, attachment_indexes_ = 0, metadata_indexes_ = 0;
};

}  // namespace palpate::record
