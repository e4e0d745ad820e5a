// Writes a recording in MCAP (https://mcap.dev/spec, version 0): messages in chunks, packed with Zstandard, each chunk with a
// CRC and an index; attachments and metadata between them; at the end a summary that finds all of it.
//
// Whatever ends the program, the chunks that were closed until then can be read: the schema and the channel of a message
// stand in the chunk of its first message, and once more in front of it, outside of all chunks, where the damage of one chunk
// does not reach. A chunk is closed when it holds `chunk_bytes` or `chunk_time` of log time, or by flush().
//
// Memory does not grow with a recording's length, but for what is attached: the index of its chunks, needed at the end, waits
// in a file without a name beside it (in memory for standard output, and where no such file can be made).
//
// One thread. What the file refuses (a full disk) is returned, and then by every later call again. A channel or schema that
// was never added throws std::invalid_argument. The same calls give the same bytes.
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>

#include "palpate/core/expected.h"
#include "palpate/record/mcap.h"
#include "palpate/record/record_file.h"
#include "palpate/time/instant.h"

namespace palpate::record {

std::string own_library();  // "palpate 0.1.0", as it stands in a file's header

struct WriterOptions {
  FileHeader header{"", own_library()};
  std::size_t chunk_bytes = 1024 * 1024;  // unpacked; a message that is longer is a chunk of its own
  Duration chunk_time = std::chrono::milliseconds(500);
  bool compress = true;
};

class McapWriter {
 public:
  static Expected<McapWriter> begin(RecordFile file, WriterOptions options = {});
  ~McapWriter();
  McapWriter(McapWriter&&) noexcept;
  McapWriter& operator=(McapWriter&&) noexcept;

  // The number of a schema or channel in this file; the same again where it is added twice.
  Expected<std::uint16_t> add_schema(const Schema& schema);
  Expected<std::uint16_t> add_channel(const Channel& channel);

  // Refused beyond kMostMessageBytes. The data is copied.
  Expected<void> write(const Message& message);
  Expected<void> attach(const Attachment& attachment);
  Expected<void> write(const Metadata& metadata);

  // Closes the chunk, so that its messages are in the file.
  Expected<void> flush();
  // Onto the disk, as far as it is in the file.
  Expected<void> sync();
  // Once: flushes, writes the summary and finishes the file.
  Expected<Statistics> close();

  const Statistics& statistics() const;  // of what was written or stands in the open chunk
  std::uint64_t file_bytes() const;      // without the open chunk

 private:
  struct State;
  explicit McapWriter(std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

}  // namespace palpate::record
