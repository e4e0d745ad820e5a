#include "palpate/record/session/session_recording.h"

#include <fmt/format.h>
#include <sys/utsname.h>

#include <thread>
#include <utility>

#include "palpate/core/log.h"
#include "palpate/core/text.h"
#include "palpate/record/session/message_schemas.h"
#include "palpate/record/session/viewer_feed.h"
#include "palpate/time/clock.h"
#include "palpate/time/utc.h"

namespace palpate::record::session {
namespace {

constexpr Log kRecordingLog("recording");

void tell_disk(const std::string& name, DiskState state, std::uint64_t dropped) {
  switch (state) {
    case DiskState::waits:
      kRecordingLog.warning(
          "warning: {}: the disk has not come back for a second; what is recorded waits in memory, and what "
          "runs goes on",
          name);
      break;
    case DiskState::drops:
      kRecordingLog.warning(
          "warning: {}: the disk is too slow: messages are lost ({} so far); what runs goes on", name,
          dropped);
      break;
    case DiskState::keeps_up:
      kRecordingLog.info("{}: the disk keeps up again; {} messages were lost so far", name, dropped);
      break;
  }
}

Words machine() {
  utsname names{};
  Words words{{"cores", fmt::format("{}", std::thread::hardware_concurrency())}};
  if (::uname(&names) == 0) {
    words["system"] = names.sysname;
    words["release"] = names.release;
    words["machine"] = names.machine;
  }
  return words;
}

}  // namespace

Expected<std::unique_ptr<SessionRecording>> SessionRecording::begin(const std::filesystem::path& file,
                                                                    RecordingOptions options) {
  auto opened = RecordFile::growing(file);
  if (!opened) return tl::unexpected(opened.error());
  const std::int64_t monotonic = MonotonicClock<PhysicsClock>::monotonic_ns();
  const std::int64_t to_utc = options.wall_time ? utc_ns() - monotonic : 0;
  std::unique_ptr<SessionRecording> recording(new SessionRecording(file, to_utc));
  SessionOptions how;
  how.on_error =
      options.on_error ? std::move(options.on_error) : [name = one_line(file.string())](const Error& error) {
        kRecordingLog.warning("warning: {}: recording has ended: {}; what runs goes on without it", name,
                              error.message);
      };
  how.on_disk = [name = one_line(file.string())](DiskState state, std::uint64_t dropped) {
    tell_disk(name, state, dropped);
  };
  auto writer = SessionWriter::begin(std::move(*opened), std::move(how));
  if (!writer) return tl::unexpected(writer.error());
  recording->writer_ = std::move(*writer);
  if (auto done =
          recording->describe("palpate.session", {{"version", own_library()},
                                                  {"recorder", options.recorder},
                                                  {"to_utc_ns", fmt::format("{}", to_utc)},
                                                  {"log_time", options.wall_time ? "UTC" : "computed"}});
      !done)
    return tl::unexpected(done.error());
  if (auto done = recording->describe("palpate.machine", machine()); !done)
    return tl::unexpected(done.error());
  return recording;
}

// The log keeps its sinks for ever; this one falls silent when its recording is closed.
struct SessionRecording::LogTap {
  std::mutex mutex;
  RecordStream* stream = nullptr;
  SessionRecording* recording = nullptr;

  void write(const LogLine& line) {
    const std::lock_guard lock(mutex);
    if (stream == nullptr) return;
    const auto time = recording->log_time(MonotonicClock<PhysicsClock>::monotonic_ns());
    stream->write(time, time, encode_log(line.level, line.text, time));
  }
};

void SessionRecording::record_log() {
  if (log_tap_) return;
  log_tap_ = std::make_shared<LogTap>();
  log_tap_->stream = &stream("/log", "foxglove.Log");
  log_tap_->recording = this;
  log_to([tap = log_tap_](const LogLine& line) { tap->write(line); });
}

SessionRecording::~SessionRecording() { close(); }

RecordStream& SessionRecording::stream(const std::string& topic, const std::string& message) {
  const std::lock_guard lock(mutex_);
  const auto found = streams_.find(topic);
  if (found != streams_.end()) return *found->second;
  RecordStream& added = writer_->add(schema_of(message), Channel{topic, "protobuf", 0, {}});
  streams_[topic] = &added;
  return added;
}

std::uint64_t SessionRecording::dropped() const {
  const std::lock_guard lock(mutex_);
  std::uint64_t sum = 0;
  for (const auto& [topic, stream] : streams_) sum += stream->dropped();
  return sum;
}

Expected<void> SessionRecording::attach(std::string name, std::string media_type, std::string data) {
  const auto now = log_time(MonotonicClock<PhysicsClock>::monotonic_ns());
  return writer_->attach(Attachment{now, now, std::move(name), std::move(media_type), std::move(data)});
}

Json SessionRecording::close() {
  if (log_tap_) {
    const std::lock_guard lock(log_tap_->mutex);
    log_tap_->stream = nullptr;
  }
  const SessionReport report = writer_->close();
  Json json = {{"file", file_.string()}, {"messages", report.written.messages}, {"bytes", report.file_bytes}};
  json["seconds"] = static_cast<double>(report.written.end_ns - report.written.start_ns) * 1e-9;
  json["dropped"] = Json::object();
  for (const auto& [topic, count] : report.dropped) json["dropped"][topic] = count;
  if (report.error) json["error"] = report.error->message;
  return json;
}

Expected<Json> SessionRecording::finish() {
  const std::string name = one_line(file_.string());
  Json figures = close();
  if (figures.contains("error"))
    return refused("{}: the recording is not whole: {}", name, figures["error"].get<std::string>());
  kRecordingLog.info("{}: {:.1f} s recorded, {:.1f} MB", name, figures["seconds"].get<double>(),
                     figures["bytes"].get<double>() * 1e-6);
  return figures;
}

}  // namespace palpate::record::session
