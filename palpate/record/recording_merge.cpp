#include "palpate/record/recording_merge.h"

#include <algorithm>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <utility>

#include "palpate/record/byte_source.h"
#include "palpate/record/internal/channel_numbers.h"
#include "palpate/record/mcap_reader.h"
#include "palpate/record/mcap_writer.h"
#include "palpate/record/message_feed.h"
#include "palpate/record/recording_info.h"

namespace palpate::record {
namespace {

// Attachments and metadata, which stand before all messages of the copy.
class Collector : public ScanHandler {
 public:
  explicit Collector(McapWriter& writer) : writer_(writer) {}
  Expected<void> attachment(const Attachment& attachment) override {
    const auto same = [&](const auto& seen) {
      return seen.first == attachment.name && seen.second == attachment.data;
    };
    if (std::any_of(seen_.begin(), seen_.end(), same)) return {};
    seen_.emplace_back(attachment.name, attachment.data);
    return writer_.attach(attachment);
  }
  Expected<void> metadata(const Metadata& metadata) override { return writer_.write(metadata); }

 private:
  McapWriter& writer_;
  std::vector<std::pair<std::string, std::string>> seen_;
};

// Of a topic that several recordings have: numbers go on, gaps remain.
class Sequences {
 public:
  std::uint32_t next(const std::string& topic, std::size_t recording, std::uint32_t sequence) {
    auto& last = last_[{topic, recording}];
    const std::uint32_t step = last ? sequence - *last : (counts_.contains(topic) ? 1 : sequence);
    last = sequence;
    auto [count, first] = counts_.try_emplace(topic, step);
    if (!first) count->second += step;
    return count->second;
  }

 private:
  std::map<std::pair<std::string, std::size_t>, std::optional<std::uint32_t>> last_;
  std::map<std::string, std::uint32_t> counts_;
};

Expected<McapWriter> begin_copy(const std::filesystem::path& out) {
  auto file = RecordFile::whole(out);
  if (!file) return tl::unexpected(file.error());
  return McapWriter::begin(std::move(*file));
}

// Whole, or refused with what is to be done.
Expected<void> collect(ByteSource& source, ScanHandler& collector) {
  const auto scanned = scan(source, {}, collector);
  if (!scanned) return tl::unexpected(scanned.error());
  if (!scanned->complete)
    return refused("{}: is not whole{}; palpate recording repair makes a whole one of it", source.name(),
                   first_fault(*scanned));
  return {};
}

Expected<void> write_in_order(const std::vector<std::unique_ptr<MessageFeed>>& feeds, McapWriter& writer) {
  std::vector<ChannelNumbers> numbers(feeds.size());
  Sequences sequences;
  while (true) {
    std::size_t earliest = feeds.size();
    const MessageFeed::Item* item = nullptr;
    for (std::size_t i = 0; i < feeds.size(); ++i)
      if (const auto* other = feeds[i]->next();
          other != nullptr && (item == nullptr || other->message.log_time_ns < item->message.log_time_ns)) {
        item = other;
        earliest = i;
      }
    if (item == nullptr) break;
    const auto number = numbers[earliest].of(item->channel, item->schema ? &*item->schema : nullptr,
                                             item->message.channel, writer);
    if (!number) return tl::unexpected(number.error());
    Message message = item->message;
    message.channel = *number;
    message.data = item->data;
    message.sequence = sequences.next(item->channel.topic, earliest, item->message.sequence);
    if (auto done = writer.write(message); !done) return done;
    feeds[earliest]->take();
  }
  for (const auto& feed : feeds)
    if (!feed->result()) return tl::unexpected(feed->result().error());
  return {};
}

}  // namespace

Expected<Statistics> merge(const std::vector<std::filesystem::path>& recordings,
                           const std::filesystem::path& out) {
  auto writer = begin_copy(out);
  if (!writer) return tl::unexpected(writer.error());
  Collector collector(*writer);
  for (const auto& recording : recordings) {
    auto source = open_source(recording);
    if (!source) return tl::unexpected(source.error());
    if (auto done = collect(**source, collector); !done) return tl::unexpected(done.error());
  }
  {
    std::vector<std::unique_ptr<MessageFeed>> feeds;
    for (const auto& recording : recordings) {
      auto source = open_source(recording);
      if (!source) return tl::unexpected(source.error());
      feeds.push_back(std::make_unique<MessageFeed>(std::move(*source), ScanOptions{}));
    }
    if (auto done = write_in_order(feeds, *writer); !done) return tl::unexpected(done.error());
  }
  return writer->close();
}

}  // namespace palpate::record
