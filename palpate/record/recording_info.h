// What a recording holds, counted by reading all of it: streams, rates, what was dropped while it was recorded, and whether it
// is whole. One thread.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "palpate/core/expected.h"
#include "palpate/core/json.h"
#include "palpate/record/mcap_reader.h"

namespace palpate::record {

// Where a live recording tells how many messages of each topic were dropped: messages whenever it changes, a metadata record
// at its end. Values are decimal numbers.
inline constexpr const char* kDropsTopic = "/recording/drops";
inline constexpr const char* kDropsMetadata = "palpate.drops";

struct StreamInfo {
  std::string name;  // the topic
  std::uint64_t messages = 0, dropped = 0;
  double rate_hz = 0.0;  // of what is there, between its first and its last message; 0 where there are no two
};

struct RecordingInfo {
  ScanResult scanned;
  double seconds = 0.0;             // between the first and the last message
  std::vector<StreamInfo> streams;  // by name
  std::string version;              // of Palpate that wrote it: "0.1.0"; of others their library
};

// Refused where it is no recording in MCAP at all; of one that is not sound, what is.
Expected<RecordingInfo> info(ByteSource& source);

Json info_json(const RecordingInfo& info);
Json check_json(const ScanResult& scanned);  // sound, faults with bytes

double seconds_of(const Statistics& statistics);
// " (byte 12: Chunk: its CRC is wrong)" of the first fault, with how many more there are; empty where there is none.
std::string first_fault(const ScanResult& scanned);

}  // namespace palpate::record
