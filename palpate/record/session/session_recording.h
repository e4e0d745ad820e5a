// The recording of a running session: one file, one timeline, topics by their names, and what belongs to it as attachments.
//
// The timeline: the machine's monotonic clock plus a constant, measured at the beginning, so that it is dated (UTC) and never
// runs backwards. Device stamps stay in the messages, in their own clocks. Any thread may write to a stream
// (palpate/record/session_writer.h); begin(), stream(), attach(), describe() and close() are for ordinary threads.
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <mutex>
#include <string>

#include "palpate/core/expected.h"
#include "palpate/core/json.h"
#include "palpate/record/session_writer.h"
#include "palpate/time/instant.h"

namespace palpate::record::session {

struct RecordingOptions {
  std::string recorder;  // who writes it: "physics"
  // What the disk refuses, once; of a thread of the recording. Empty: the log is told.
  std::function<void(const Error&)> on_error;
  bool wall_time = true;  // false, where time is computed: log times are those of the clock itself
};

class SessionRecording {
 public:
  // A new file; refused where one is there already, or the folder cannot be written.
  static Expected<std::unique_ptr<SessionRecording>> begin(const std::filesystem::path& file,
                                                           RecordingOptions options);
  ~SessionRecording();  // closes
  SessionRecording(const SessionRecording&) = delete;
  SessionRecording& operator=(const SessionRecording&) = delete;

  // The stream of a topic, made where it is asked for first; `message`: the full name of its protobuf type,
  // "palpate.recording.ArmSample". Throws std::invalid_argument for a type that is not of proto/.
  RecordStream& stream(const std::string& topic, const std::string& message);

  // On the timeline; `monotonic_ns`: of the machine's clock.
  std::uint64_t log_time(std::int64_t monotonic_ns) const {
    return static_cast<std::uint64_t>(monotonic_ns + to_utc_ns_);
  }

  // From here on the log's lines as well, on /log as foxglove.Log.
  void record_log();

  Expected<void> attach(std::string name, std::string media_type, std::string data);
  Expected<void> describe(std::string name, Words words) {
    return writer_->write(Metadata{std::move(name), std::move(words)});
  }

  const std::filesystem::path& file() const { return file_; }
  bool ended() const { return writer_->ended(); }  // an error has ended it
  std::uint64_t dropped() const;                   // messages of all its streams so far
  // Once: everything is in the file when it returns. What it holds, and what was dropped, as JSON for figures and a person.
  Json close();
  // The same for who ends a session: the log is told what the file holds; refused where the disk has refused.
  Expected<Json> finish();

 private:
  SessionRecording(std::filesystem::path file, std::int64_t to_utc_ns)
      : file_(std::move(file)), to_utc_ns_(to_utc_ns) {}

  std::filesystem::path file_;
  std::int64_t to_utc_ns_;
  struct LogTap;
  mutable std::mutex mutex_;
  std::shared_ptr<LogTap> log_tap_;  // null: the log is not recorded
  std::map<std::string, RecordStream*> streams_;
  std::unique_ptr<SessionWriter> writer_;
};

}  // namespace palpate::record::session
