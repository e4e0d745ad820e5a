// Recordings in MCAP, ours and those of others: whatever stands in them the scan ends, what it hands over it also counts, a
// fault is one line, and what a strict scan finds first a tolerant one finds, too.
#include "palpate/core/text.h"
#include "palpate/record/mcap_reader.h"

#include "fuzz/check.h"

namespace palpate::fuzz {
namespace {

constexpr std::uint64_t kMostChunk = 4 * 1024 * 1024;  // unpacked, so that one execution stays short

struct CountedRecords : record::ScanHandler {
  record::Statistics heard;

  Expected<void> message(const record::HeardMessage& message) override {
    ++heard.messages;
    ++heard.messages_of_channels[message.message.channel];
    hold((message.schema != nullptr) == (message.channel.schema != 0),
         "a message's schema is known or is none");
    return {};
  }
  Expected<void> attachment(const record::Attachment&) override {
    ++heard.attachments;
    return {};
  }
  Expected<void> metadata(const record::Metadata&) override {
    ++heard.metadata;
    return {};
  }
};

}  // namespace

Refusals recordings(std::string_view file) {
  Refusals refusals;
  record::MemorySource source(file, "session.mcap");
  record::ScanOptions options;
  options.most_chunk_bytes = kMostChunk;
  CountedRecords tolerant, strict;
  const auto all = record::scan(source, options, tolerant);
  options.tolerant = false;
  const auto first = record::scan(source, options, strict);
  if (!answered(all, refusals)) return refusals;
  hold(all->found.messages == tolerant.heard.messages &&
           all->found.attachments == tolerant.heard.attachments &&
           all->found.metadata == tolerant.heard.metadata &&
           all->found.messages_of_channels == tolerant.heard.messages_of_channels,
       "what is handed over is counted");
  hold(all->complete ? all->fault_count == 0 : all->fault_count > 0, "what is not whole has a fault");
  hold_finite(all->lost_s, "lost time is a number");
  hold(all->lost_s >= 0.0, "lost time is not negative");
  for (const auto& fault : all->faults) {
    hold(fault.offset <= file.size(), "a fault lies in the file");
    hold_one_line({Error::Kind::refused, fault.words});
  }
  if (!answered(first, refusals)) return refusals;
  hold(first->fault_count == (all->fault_count > 0 ? 1u : 0u), "a strict scan ends at the first fault");
  if (all->fault_count > 0) {
    const auto& fault = all->faults.front();
    hold(first->faults.front().offset == fault.offset && first->faults.front().words == fault.words,
         "both scans meet the same fault first");
    hold(strict.heard.messages <= tolerant.heard.messages, "a strict scan hands over no more");
    refusals.push_back(
        fmt::format("session.mcap: byte {}: {}; palpate recording repair", fault.offset, fault.words));
  }
  return refusals;
}

}  // namespace palpate::fuzz
