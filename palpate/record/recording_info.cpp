#include "palpate/record/recording_info.h"

#include <algorithm>
#include <charconv>
#include <map>
#include <utility>

#include "palpate/core/text.h"

namespace palpate::record {
namespace {

constexpr std::size_t kMostDropsBytes = 1'000'000;  // of one message; ours take some hundred

class Counter : public ScanHandler {
 public:
  struct Stream {
    std::uint64_t messages = 0, dropped = 0, first_ns = 0, last_ns = 0;
  };

  Expected<void> message(const HeardMessage& heard) override {
    auto& stream = streams_[heard.channel.topic];
    const auto time = heard.message.log_time_ns;
    if (stream.messages++ == 0) stream.first_ns = stream.last_ns = time;
    stream.first_ns = std::min(stream.first_ns, time);
    stream.last_ns = std::max(stream.last_ns, time);
    if (heard.channel.topic == kDropsTopic) take_drops(heard.message.data);
    return {};
  }
  Expected<void> metadata(const Metadata& metadata) override {
    if (metadata.name == kDropsMetadata)
      for (const auto& [topic, count] : metadata.values) {
        std::uint64_t dropped = 0;
        std::from_chars(count.data(), count.data() + count.size(), dropped);
        streams_[topic].dropped = dropped;
      }
    return {};
  }
  const std::map<std::string, Stream>& streams() const { return streams_; }

 private:
  // {"dropped": {"/arm/sample": 12}}; of a recording that has no end, the last one tells.
  void take_drops(std::string_view text) {
    if (text.size() > kMostDropsBytes) return;
    const auto json = Json::parse(text, nullptr, false);
    if (!json.is_object() || !json.contains("dropped") || !json["dropped"].is_object()) return;
    for (const auto& [topic, count] : json["dropped"].items())
      if (count.is_number_unsigned()) streams_[topic].dropped = count.get<std::uint64_t>();
  }
  std::map<std::string, Stream> streams_;
};

double seconds_between(std::uint64_t first_ns, std::uint64_t last_ns) {
  return 1e-9 * static_cast<double>(last_ns - first_ns);
}

}  // namespace

double seconds_of(const Statistics& statistics) {
  return seconds_between(statistics.start_ns, statistics.end_ns);
}

std::string first_fault(const ScanResult& scanned) {
  if (scanned.faults.empty()) return "";
  const auto& fault = scanned.faults.front();
  const auto more = scanned.fault_count - 1;
  return fmt::format(" (byte {}: {}{})", fault.offset, fault.words,
                     more == 0 ? "" : fmt::format("; and {}", counted(more, "more fault")));
}

Expected<RecordingInfo> info(ByteSource& source) {
  Counter counter;
  auto scanned = scan(source, {}, counter);
  if (!scanned) return tl::unexpected(scanned.error());
  const auto& found = scanned->found;
  if (auto fine = check_is_recording(*scanned, source.name()); !fine) return tl::unexpected(fine.error());
  RecordingInfo info;
  info.seconds = seconds_of(found);
  for (const auto& [name, stream] : counter.streams()) {
    const double span_s = seconds_between(stream.first_ns, stream.last_ns);
    info.streams.push_back({name, stream.messages, stream.dropped,
                            span_s > 0.0 ? static_cast<double>(stream.messages - 1) / span_s : 0.0});
  }
  const std::string& library = scanned->header.library;
  constexpr std::string_view kOurs = "palpate ";
  info.version = library.starts_with(kOurs) ? library.substr(kOurs.size()) : library;
  info.scanned = std::move(*scanned);
  return info;
}

Json check_json(const ScanResult& scanned) {
  Json json;
  json["sound"] = scanned.complete;
  json["messages"] = scanned.found.messages;
  json["chunks"] = scanned.found.chunks;
  json["attachments"] = scanned.found.attachments;
  json["metadata"] = scanned.found.metadata;
  json["faults"] = Json::array();
  for (const auto& fault : scanned.faults)
    json["faults"].push_back({{"byte", fault.offset}, {"what", fault.words}});
  json["fault_count"] = scanned.fault_count;
  json["lost_bytes"] = scanned.lost_bytes;
  json["lost_chunks"] = scanned.lost_chunks;
  json["lost_s"] = scanned.lost_s;
  return json;
}

Json info_json(const RecordingInfo& info) {
  Json json;
  json["seconds"] = info.seconds;
  json["streams"] = Json::array();
  for (const auto& stream : info.streams)
    json["streams"].push_back({{"name", stream.name},
                               {"messages", stream.messages},
                               {"dropped", stream.dropped},
                               {"rate_hz", stream.rate_hz}});
  json["version"] = info.version;
  json["complete"] = info.scanned.complete;
  json["library"] = info.scanned.header.library;
  json["start_ns"] = info.scanned.found.start_ns;
  json["attachments"] = info.scanned.found.attachments;
  json["metadata"] = info.scanned.found.metadata;
  return json;
}

}  // namespace palpate::record
