// For tests: small recordings with closed-form content, and what a scan hears.
#pragma once

#include <gtest/gtest.h>
#include <sys/resource.h>

#include <csignal>
#include <cstdint>
#include <filesystem>
#include <iterator>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "palpate/core/file.h"
#include "palpate/record/mcap_reader.h"
#include "palpate/record/mcap_writer.h"
#include "tests/scratch_folder.h"

namespace palpate::record {

constexpr std::uint64_t kStartNs = 1'700'000'000'000'000'000;

struct HeardLine {
  std::string topic, schema, data;
  std::uint32_t sequence = 0;
  std::uint64_t log_time_ns = 0;
  bool operator==(const HeardLine&) const = default;
};

class Listener : public ScanHandler {
 public:
  Expected<void> message(const HeardMessage& heard) override {
    lines.push_back({heard.channel.topic, heard.schema != nullptr ? heard.schema->name : "",
                     std::string(heard.message.data), heard.message.sequence, heard.message.log_time_ns});
    return {};
  }
  Expected<void> attachment(const Attachment& attachment) override {
    attachments[attachment.name] = attachment.data;
    return {};
  }
  Expected<void> metadata(const Metadata& heard) override {
    metadata_of[heard.name] = heard.values;
    return {};
  }
  std::vector<HeardLine> lines;
  std::map<std::string, std::string> attachments;
  std::map<std::string, Words> metadata_of;
};

inline ScanResult scanned(std::string_view bytes, Listener& listener, const ScanOptions& options = {}) {
  MemorySource source(bytes);
  auto result = scan(source, options, listener);
  EXPECT_TRUE(result) << result.error().message;
  return result ? *result : ScanResult{};
}
inline ScanResult scanned(std::string_view bytes) {
  Listener nobody;
  return scanned(bytes, nobody);
}

struct SmallRecording {
  int messages = 12;
  WriterOptions options;
  std::size_t padding = 0;  // bytes of each message beside its number
};

// Two topics in turn, a message every 100 ms, an attachment and metadata in the middle.
inline std::string small_recording(const SmallRecording& what = {}) {
  const ScratchFolder folder;
  auto writer = McapWriter::begin(*RecordFile::growing(folder / "small.mcap"), what.options);
  const auto schema = *writer->add_schema({"palpate.Arm", "jsonschema", R"({"type":"object"})"});
  const auto arm = *writer->add_channel({"/arm/sample", "json", schema, {{"clock", "arm"}}});
  const auto plain = *writer->add_channel({"/plain", "", 0, {}});
  for (int i = 0; i < what.messages; ++i) {
    const auto time = kStartNs + 100'000'000ull * static_cast<std::uint64_t>(i);
    const auto data = "{\"i\":" + std::to_string(i) + "}" + std::string(what.padding, ' ');
    EXPECT_TRUE(writer->write(
        Message{i % 2 == 0 ? arm : plain, static_cast<std::uint32_t>(i / 2), time, time - 5, data}));
    if (i == what.messages / 2) {
      EXPECT_TRUE(writer->attach({time, time, "rig.toml", "application/toml", "name = \"rig\"\n"}));
      EXPECT_TRUE(writer->write(Metadata{"session", {{"id", "7"}, {"who", "nobody"}}}));
    }
  }
  EXPECT_TRUE(writer->close());
  return *read_file(folder / "small.mcap");
}

inline std::vector<HeardLine> lines_of(const std::string& bytes) {
  Listener listener;
  EXPECT_TRUE(scanned(bytes, listener).complete);
  return listener.lines;
}

// No file can grow beyond this, whoever the user is; what a full disk does, too.
class FileLimit {
 public:
  explicit FileLimit(rlim_t bytes) {
    std::signal(SIGXFSZ, SIG_IGN);
    ::getrlimit(RLIMIT_FSIZE, &before_);
    const rlimit low{bytes, before_.rlim_max};
    ::setrlimit(RLIMIT_FSIZE, &low);
  }
  ~FileLimit() { ::setrlimit(RLIMIT_FSIZE, &before_); }

 private:
  rlimit before_{};
};

// Files with a name in a folder.
inline std::ptrdiff_t files_in(const std::filesystem::path& folder) {
  return std::distance(std::filesystem::directory_iterator(folder), {});
}

}  // namespace palpate::record
