// Reads recordings in MCAP (https://mcap.dev/spec, version 0), ours and those of others, and trusts none: every length, every
// CRC, every index and the statistics are compared with what is there.
//
// A scan goes through the file once, in its order, and hands over what is sound. A fault is a byte offset and what is wrong
// there; a scan that is tolerant goes on behind it, at the next chunk that is sound where nothing tells where the next record
// begins. Chunks are packed with Zstandard or not at all.
// Memory: one chunk packed and unpacked (at most `most_chunk_bytes`), what tells of channels (64 MiB), the index of chunks.
// One thread.
#pragma once

#include <cstdint>
#include <limits>
#include <string>
#include <vector>

#include "palpate/core/expected.h"
#include "palpate/record/byte_source.h"
#include "palpate/record/mcap.h"

namespace palpate::record {

struct Fault {
  std::uint64_t offset = 0;  // in the file, of the record or its part
  std::string words;         // plain, without an end: "Chunk: its CRC is wrong"
};

struct HeardMessage {
  const Message& message;
  const Channel& channel;
  const Schema* schema = nullptr;  // null: of none
};

// What a scan hands over, as long as the call lasts. An error ends the scan, which returns it.
class ScanHandler {
 public:
  virtual ~ScanHandler() = default;
  virtual Expected<void> message(const HeardMessage&) { return {}; }
  virtual Expected<void> attachment(const Attachment&) { return {}; }
  virtual Expected<void> metadata(const Metadata&) { return {}; }
};

struct ScanOptions {
  bool tolerant = true;                                             // false: ends at the first fault
  std::vector<std::string> topics;                                  // none: all
  std::uint64_t from_ns = 0;                                        // log times from here on
  std::uint64_t to_ns = std::numeric_limits<std::uint64_t>::max();  // to this one, which belongs to them
  std::uint64_t most_chunk_bytes = kMostChunkBytes;                 // unpacked
};

struct ScanResult {
  FileHeader header;
  Statistics found;           // of all that is sound, whatever was asked for
  bool complete = false;      // whole, with its summary and its end, and without a fault
  std::vector<Fault> faults;  // the first hundred
  std::uint64_t fault_count = 0;
  std::uint64_t lost_bytes = 0;   // of records that are damaged or cut off
  std::uint64_t lost_chunks = 0;  // among them, as far as they are recognised
  double lost_s = 0.0;  // of log time between sound messages, or until the end that a cut chunk tells of
};

// Refused where the file cannot be read, is packed with what is not known here, or the handler refuses. What is not sound is
// no error but a fault.
Expected<ScanResult> scan(ByteSource& source, const ScanOptions& options, ScanHandler& handler);

// Wrong use, where what was scanned begins unlike a recording and holds nothing of one.
Expected<void> check_is_recording(const ScanResult& scanned, const std::string& name);

}  // namespace palpate::record
