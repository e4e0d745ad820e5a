// Records a running session: streams that any thread feeds without ever waiting, and a thread of its own that writes them to a
// file in MCAP.
//
//   RecordStream::write()   any thread, the 1 kHz loops among them: no lock, no allocation, no call of the system. What finds
//                           no room in the queue is dropped (the newest) and counted.
//   the writing thread      closes a chunk every 0.5 s at the latest, is through to the disk every 2 s, and tells of drops in
//                           the file: on the topic /recording/drops when they change, and in the metadata palpate.drops.
//   all else                ordinary threads; locks for moments
//
//   a thread that watches     tells of a disk that does not come back, and of the first drop, while the writing thread waits
//
// An error of the disk is told once and ends the recording; whoever feeds it goes on undisturbed, and what it feeds counts as
// dropped. Times are those of the caller: log times of all streams are on one timeline, nanoseconds. When a chunk is closed
// depends on the machine's clock: who needs the same bytes each time writes them with McapWriter, in the thread that ticks.
#pragma once

#include <atomic>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include "palpate/core/expected.h"
#include "palpate/record/mcap.h"
#include "palpate/record/mcap_writer.h"
#include "palpate/record/record_file.h"
#include "palpate/time/instant.h"

namespace palpate::record {

// How the disk keeps up. Told when it changes.
enum class DiskState : std::uint8_t {
  waits,  // it has not come back for a second; what comes is kept in the queue
  drops,  // the queue is full: messages are being lost
  keeps_up,
};

struct SessionOptions {
  std::size_t queue_bytes = 64 * 1024 * 1024, queue_messages = 262'144;
  Duration flush_every = std::chrono::milliseconds(500);  // at the latest
  Duration sync_every = std::chrono::seconds(2);
  WriterOptions writer;
  // Of the writing thread, at most once; may not call back into the writer.
  std::function<void(const Error&)> on_error;
  // Of the watching thread, with what has been dropped so far; may not call back into the writer.
  std::function<void(DiskState, std::uint64_t dropped)> on_disk;
};

struct SessionReport {
  std::optional<Error> error;  // what ended the recording before its time
  Statistics written;          // after an error also what its last chunk would have held
  std::uint64_t file_bytes = 0;
  std::map<std::string, std::uint64_t> dropped;  // of each topic that lost some
};

class RecorderQueue;

// Where one topic goes; lives as long as its SessionWriter.
class RecordStream {
 public:
  // False where it is dropped. Messages that are written at the same time by several threads stand in any order.
  bool write(std::uint64_t log_time_ns, std::uint64_t publish_time_ns, std::string_view data) noexcept;
  // One that its source could not even hand over: it counts as dropped.
  void drop() noexcept {
    offered_.fetch_add(1, std::memory_order_relaxed);
    dropped_.fetch_add(1, std::memory_order_relaxed);
  }
  std::uint64_t dropped() const { return dropped_.load(std::memory_order_relaxed); }

 private:
  friend class SessionWriter;
  RecordStream(RecorderQueue& queue, const std::atomic<bool>& ended, std::uint16_t number)
      : queue_(queue), ended_(ended), number_(number) {}
  RecorderQueue& queue_;
  const std::atomic<bool>& ended_;
  const std::uint16_t number_;
  std::atomic<std::uint32_t> offered_{0};  // the sequence: what is dropped leaves a gap
  std::atomic<std::uint64_t> dropped_{0};
};

class SessionWriter {
 public:
  static Expected<std::unique_ptr<SessionWriter>> begin(RecordFile file, SessionOptions options = {});
  ~SessionWriter();  // closes
  SessionWriter(const SessionWriter&) = delete;
  SessionWriter& operator=(const SessionWriter&) = delete;

  // `channel.schema` is not looked at: `schema` takes its place; an empty one is none. Throws std::invalid_argument beyond 65000 streams.
  RecordStream& add(const Schema& schema, const Channel& channel);
  // Refused where 256 MiB of them wait to be written.
  Expected<void> attach(Attachment attachment);
  Expected<void> write(Metadata metadata);

  // Whether an error has ended it.
  bool ended() const;
  // Writes what is in the queue and the summary; then, and after every further call, what happened. Streams drop from here on. A
  // disk that does not come back for 1.5 s, or takes longer than 10 s in all, is not waited for: that is an error, and the rest is lost.
  SessionReport close();

 private:
  struct State;
  explicit SessionWriter(std::shared_ptr<State> state);
  std::shared_ptr<State> state_;
  SessionReport report_;  // after close()
};

}  // namespace palpate::record
