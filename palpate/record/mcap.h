// What a recording in MCAP (https://mcap.dev/spec, version 0) holds, as values: messages on channels, each of a schema, and
// beside them attachments (whole files) and metadata (texts).
//
// Times are nanoseconds on one timeline that whoever records chooses: `log_time_ns` orders the file, `publish_time_ns` is the
// sender's own. Texts are UTF-8. Plain values: any thread.
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <string_view>

namespace palpate::record {

// The most that a reader takes into memory at once, and that a writer therefore writes, bytes.
inline constexpr std::uint64_t kMostChunkBytes = 256ull * 1024 * 1024;  // of messages, unpacked
inline constexpr std::uint64_t kMostMessageBytes =
    128ull * 1024 * 1024;  // a picture of 4000 x 3000 has 36 MB
inline constexpr std::uint64_t kMostAttachmentBytes = 256ull * 1024 * 1024;  // and of any other record

using Words = std::map<std::string, std::string>;

struct FileHeader {
  std::string profile;  // which agreement the topics keep to; ours: none
  std::string library;  // who wrote the file: "palpate 0.1.0"
  bool operator==(const FileHeader&) const = default;
};

// How the data of messages is to be read.
struct Schema {
  std::string name;      // "palpate.wire.WorldState"
  std::string encoding;  // "protobuf", "jsonschema"; empty: none
  std::string data;      // of protobuf a FileDescriptorSet with all imports
  bool operator==(const Schema&) const = default;
};

struct Channel {
  std::string topic;             // "/arm/sample"
  std::string message_encoding;  // "protobuf", "json"
  std::uint16_t schema = 0;      // its number within the file; 0: none
  Words metadata;
  bool operator==(const Channel&) const = default;
};

struct Message {
  std::uint16_t channel = 0;   // its number within the file
  std::uint32_t sequence = 0;  // of its channel; what is missing in between has been dropped
  std::uint64_t log_time_ns = 0, publish_time_ns = 0;
  std::string_view data;
};

struct Attachment {
  std::uint64_t log_time_ns = 0, create_time_ns = 0;
  std::string name;        // "rig.toml"
  std::string media_type;  // "application/toml"
  std::string data;
};

struct Metadata {
  std::string name;  // "palpate.drops"
  Words values;
};

struct Statistics {
  std::uint64_t messages = 0;
  std::uint16_t schemas = 0;
  std::uint32_t channels = 0, attachments = 0, metadata = 0, chunks = 0;
  std::uint64_t start_ns = 0, end_ns = 0;  // log times of the earliest and the latest message
  std::map<std::uint16_t, std::uint64_t> messages_of_channels;  // those that have some
  bool operator==(const Statistics&) const = default;
};

}  // namespace palpate::record
