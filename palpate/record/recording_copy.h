// Makes a new recording of what is sound in another: all of it (repair), or some topics over some time (cut). One thread.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "palpate/core/expected.h"
#include "palpate/record/mcap_reader.h"

namespace palpate::record {

// What the metadata of a copy tells of it.
inline constexpr const char* kRepairMetadata = "palpate.repair";
inline constexpr const char* kCutMetadata = "palpate.cut";

struct CopyReport {
  ScanResult scanned;  // of the original
  Statistics written;  // of the copy
};

// A complete recording of everything that is sound, there whole or not at all; "-" is standard output. Refused where nothing is.
Expected<CopyReport> repair(ByteSource& source, const std::filesystem::path& out);

// Log time so many seconds after `start`, ns, as far as it goes.
std::uint64_t later(std::uint64_t start, double s);

struct Cut {
  double from_s = 0.0, to_s = 0.0;  // after the first message of the recording
  std::vector<std::string> topics;  // none: all
};
// Attachments and metadata come along. Refused where no message is left, or where the recording is not sound: repair it first.
Expected<CopyReport> cut(ByteSource& source, const std::filesystem::path& out, const Cut& cut);

}  // namespace palpate::record
