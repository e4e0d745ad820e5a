#include "palpate/record/session_writer.h"

#include <pthread.h>

#include <algorithm>
#include <condition_variable>
#include <deque>
#include <exception>
#include <mutex>
#include <stdexcept>
#include <thread>
#include <utility>
#include <variant>
#include <vector>

#include "palpate/core/json.h"
#include "palpate/record/recorder_queue.h"
#include "palpate/record/recording_info.h"
#include "palpate/time/standstill.h"

namespace palpate::record {
namespace {

constexpr std::chrono::milliseconds kLookEvery{5};
constexpr std::chrono::milliseconds kWatchEvery{100};
constexpr Duration kDiskPatience = std::chrono::seconds(1);
// At the end: for a disk that does not come back, and for one that does, again and again.
constexpr Duration kEndPatience = std::chrono::milliseconds(1500), kLongestEnd = std::chrono::seconds(10);
constexpr std::size_t kMostStreams = 65'000;
constexpr std::uint64_t kMostWaiting = 256ull * 1024 * 1024;  // of attachments and metadata, bytes
constexpr int kMessagesBetweenLooks = 256;                    // at the clock

using SteadyTime = std::chrono::steady_clock::time_point;

const Schema kDropsSchema{
    "palpate.Drops", "jsonschema",
    R"({"type":"object","properties":{"dropped":{"type":"object","additionalProperties":{"type":"integer"}}}})"};

}  // namespace

bool RecordStream::write(std::uint64_t log_time_ns, std::uint64_t publish_time_ns,
                         std::string_view data) noexcept {
  const auto sequence = offered_.fetch_add(1, std::memory_order_relaxed);
  if (!ended_.load(std::memory_order_relaxed) && data.size() <= kMostMessageBytes &&
      queue_.push({number_, sequence, log_time_ns, publish_time_ns, data}))
    return true;
  dropped_.fetch_add(1, std::memory_order_relaxed);
  return false;
}

struct SessionWriter::State {
  struct Declared {
    Schema schema;
    Channel channel;
    std::unique_ptr<RecordStream> stream;
    std::uint16_t channel_number = 0;  // in the file; 0: not there yet. The writing thread's
  };

  State(McapWriter to, SessionOptions how)
      : options(std::move(how)), queue(options.queue_bytes, options.queue_messages), writer(std::move(to)) {}

  // Of the writing thread.
  void run();
  Expected<void> work();
  Expected<void> take_aside();
  Expected<void> write_queued(SteadyTime& flushed, SteadyTime& synced);
  Expected<void> write_message(const Message& message);
  Expected<void> keep_time(SteadyTime& flushed, SteadyTime& synced);
  Expected<void> tell_drops();
  Expected<void> finish();
  void fail(Error error);

  // Of who closes: waits for the writing thread; false: the disk keeps it.
  bool await_end();
  // Of the watching thread.
  void watch();
  std::uint64_t all_dropped();

  // Under the mutex.
  std::map<std::string, std::uint64_t> drops();

  const SessionOptions options;
  RecorderQueue queue;
  std::atomic<bool> ended{false};  // by an error or by close(): nothing is taken any more
  std::atomic<bool> failed{false};
  std::mutex mutex;
  std::condition_variable wake, wake_watch;
  bool stop = false;             // under the mutex, as the next five
  bool has_ended = false;        // the writing thread has ended
  bool given_up = false;         // nobody waits for it any more, nor wants to hear from it
  std::deque<Declared> streams;  // grows, and never moves what it holds
  std::deque<std::variant<Attachment, Metadata>> aside;
  std::uint64_t aside_bytes = 0;

  // The writing thread's alone.
  McapWriter writer;
  std::vector<Declared*> known;  // by number of the stream
  std::map<std::string, std::uint64_t> drops_told;
  std::uint16_t drops_channel = 0;
  std::uint32_t drops_sequence = 0;
  std::uint64_t newest_ns = 0;
  bool any_message = false;
  SessionReport report;  // read after the thread has ended

  std::atomic<std::uint64_t> turns{0};  // of the writing thread: stand still while the disk has it
  std::thread thread, watching;
};

std::map<std::string, std::uint64_t> SessionWriter::State::drops() {
  std::map<std::string, std::uint64_t> counts;
  for (const auto& declared : streams)
    if (const auto dropped = declared.stream->dropped(); dropped > 0)
      counts[declared.channel.topic] += dropped;
  return counts;
}

// What came beside the queue.
Expected<void> SessionWriter::State::take_aside() {
  std::deque<std::variant<Attachment, Metadata>> taken;
  {
    const std::lock_guard lock(mutex);
    while (known.size() < streams.size()) known.push_back(&streams[known.size()]);
    taken.swap(aside);
    aside_bytes = 0;
  }
  for (const auto& item : taken) {
    const auto* attachment = std::get_if<Attachment>(&item);
    auto done = attachment != nullptr ? writer.attach(*attachment) : writer.write(std::get<Metadata>(item));
    if (!done) return done;
  }
  return {};
}

Expected<void> SessionWriter::State::write_message(const Message& message) {
  // A stream is declared before it is fed.
  if (message.channel >= known.size())
    if (auto done = take_aside(); !done) return done;
  Declared& declared = *known[message.channel];
  if (declared.channel_number == 0) {
    Channel channel = declared.channel;
    channel.schema = 0;
    if (!(declared.schema == Schema{})) {
      const auto schema = writer.add_schema(declared.schema);
      if (!schema) return tl::unexpected(schema.error());
      channel.schema = *schema;
    }
    const auto number = writer.add_channel(channel);
    if (!number) return tl::unexpected(number.error());
    declared.channel_number = *number;
  }
  newest_ns = any_message ? std::max(newest_ns, message.log_time_ns) : message.log_time_ns;
  any_message = true;
  Message numbered = message;
  numbered.channel = declared.channel_number;
  return writer.write(numbered);
}

Expected<void> SessionWriter::State::tell_drops() {
  std::map<std::string, std::uint64_t> now;
  {
    const std::lock_guard lock(mutex);
    now = drops();
  }
  // Before the first message there is no time that it could have.
  if (now == drops_told || !any_message) return {};
  if (drops_channel == 0) {
    const auto schema = writer.add_schema(kDropsSchema);
    if (!schema) return tl::unexpected(schema.error());
    const auto number = writer.add_channel({kDropsTopic, "json", *schema, {}});
    if (!number) return tl::unexpected(number.error());
    drops_channel = *number;
  }
  const std::string text = Json{{"dropped", now}}.dump(-1, ' ', false, Json::error_handler_t::replace);
  drops_told = std::move(now);
  return writer.write(Message{drops_channel, drops_sequence++, newest_ns, newest_ns, text});
}

Expected<void> SessionWriter::State::keep_time(SteadyTime& flushed, SteadyTime& synced) {
  turns.fetch_add(1, std::memory_order_relaxed);
  const auto now = std::chrono::steady_clock::now();
  if (now - flushed >= options.flush_every) {
    flushed = now;
    if (auto done = tell_drops(); !done) return done;
    if (auto done = writer.flush(); !done) return done;
  }
  if (now - synced >= options.sync_every) {
    synced = now;
    return writer.sync();
  }
  return {};
}

// All that is there, looking at the clock in between.
Expected<void> SessionWriter::State::write_queued(SteadyTime& flushed, SteadyTime& synced) {
  Expected<void> done;
  int count = 0;
  while (done && queue.pop([&](const Message& message) { done = write_message(message); }))
    if (done && ++count % kMessagesBetweenLooks == 0) done = keep_time(flushed, synced);
  return done;
}

Expected<void> SessionWriter::State::work() {
  auto flushed = std::chrono::steady_clock::now(), synced = flushed;
  for (bool stopping = false; !stopping;) {
    {
      std::unique_lock lock(mutex);
      wake.wait_for(lock, kLookEvery, [&] { return stop; });
      stopping = stop;
    }
    if (auto done = take_aside(); !done) return done;
    if (auto done = write_queued(flushed, synced); !done) return done;
    if (auto done = keep_time(flushed, synced); !done) return done;
  }
  return finish();
}

Expected<void> SessionWriter::State::finish() {
  if (auto done = tell_drops(); !done) return done;
  Metadata metadata{kDropsMetadata, {}};
  {
    const std::lock_guard lock(mutex);
    for (const auto& declared : streams) metadata.values[declared.channel.topic] = "0";
    for (const auto& [topic, count] : drops()) metadata.values[topic] = std::to_string(count);
  }
  if (auto done = writer.write(metadata); !done) return done;
  const auto written = writer.close();
  return written ? Expected<void>{} : tl::unexpected(written.error());
}

void SessionWriter::State::fail(Error error) {
  ended = true;
  failed = true;
  {
    const std::lock_guard lock(mutex);
    if (given_up) return;
  }
  if (options.on_error) options.on_error(error);
  report.error = std::move(error);
}

void SessionWriter::State::run() {
  ::pthread_setname_np(::pthread_self(), "palpate-record");
  try {
    if (auto done = work(); !done) fail(done.error());
  } catch (const std::exception& error) {  // no memory left
    fail({Error::Kind::refused,
          std::string("recording: ") + error.what() + "; less is to be recorded at once"});
  }
  {
    const std::lock_guard lock(mutex);
    has_ended = true;
  }
  wake_watch.notify_all();
}

bool SessionWriter::State::await_end() {
  Standstill<PhysicsClock> stands(kEndPatience);
  const Instant<PhysicsClock> begun;
  Instant<PhysicsClock> looked;
  std::unique_lock lock(mutex);
  while (!wake_watch.wait_for(lock, kWatchEvery, [this] { return has_ended; })) {
    looked += kWatchEvery;
    if (!stands.look(turns.load(std::memory_order_relaxed), looked) && looked - begun < kLongestEnd) continue;
    given_up = true;
    return false;
  }
  return true;
}

std::uint64_t SessionWriter::State::all_dropped() {
  std::uint64_t sum = 0;
  for (const auto& [topic, count] : drops()) sum += count;
  return sum;
}

// Its own looks are the time it counts by: a process that was stopped as a whole calls no disk slow.
void SessionWriter::State::watch() {
  ::pthread_setname_np(::pthread_self(), "palpate-disk");
  Standstill<PhysicsClock> stands(kDiskPatience);
  Instant<PhysicsClock> looked, in_trouble;
  DiskState told = DiskState::keeps_up;
  std::uint64_t dropped_before = 0;
  std::unique_lock lock(mutex);
  while (!wake_watch.wait_for(lock, kWatchEvery, [this] { return has_ended || given_up; })) {
    looked += kWatchEvery;
    const std::uint64_t dropped = all_dropped();
    const bool waits = stands.look(turns.load(std::memory_order_relaxed), looked),
               drops = dropped > dropped_before;
    dropped_before = dropped;
    if (waits || drops) in_trouble = looked;
    DiskState now = told;
    if (drops)
      now = DiskState::drops;
    else if (waits && told == DiskState::keeps_up)
      now = DiskState::waits;
    else if (looked - in_trouble >= kDiskPatience)
      now = DiskState::keeps_up;
    // After an error there is no disk to wait for, and everything is dropped.
    if (now == told || failed) continue;
    told = now;
    lock.unlock();
    if (options.on_disk) options.on_disk(now, dropped);
    lock.lock();
  }
}

SessionWriter::SessionWriter(std::shared_ptr<State> state) : state_(std::move(state)) {
  // It may outlive this object, where a disk never comes back.
  state_->thread = std::thread([kept = state_] { kept->run(); });
  state_->watching = std::thread([this] { state_->watch(); });
}

Expected<std::unique_ptr<SessionWriter>> SessionWriter::begin(RecordFile file, SessionOptions options) {
  auto writer = McapWriter::begin(std::move(file), options.writer);
  if (!writer) return tl::unexpected(writer.error());
  return std::unique_ptr<SessionWriter>(
      new SessionWriter(std::make_shared<State>(std::move(*writer), std::move(options))));
}

SessionWriter::~SessionWriter() { close(); }

RecordStream& SessionWriter::add(const Schema& schema, const Channel& channel) {
  const std::lock_guard lock(state_->mutex);
  const std::size_t number = state_->streams.size();
  if (number >= kMostStreams) throw std::invalid_argument("SessionWriter: more than 65000 streams");
  std::unique_ptr<RecordStream> stream(
      new RecordStream(state_->queue, state_->ended, static_cast<std::uint16_t>(number)));
  state_->streams.push_back({schema, channel, std::move(stream)});
  return *state_->streams.back().stream;
}

namespace {
tl::unexpected<Error> too_much_waits() {
  return refused("recording: more than 256 MiB of attachments wait for the disk; at most that is expected");
}
}  // namespace

Expected<void> SessionWriter::attach(Attachment attachment) {
  const std::lock_guard lock(state_->mutex);
  if (state_->aside_bytes + attachment.data.size() > kMostWaiting) return too_much_waits();
  state_->aside_bytes += attachment.data.size();
  state_->aside.emplace_back(std::move(attachment));
  return {};
}

Expected<void> SessionWriter::write(Metadata metadata) {
  std::uint64_t bytes = 0;
  for (const auto& [key, value] : metadata.values) bytes += key.size() + value.size();
  const std::lock_guard lock(state_->mutex);
  if (state_->aside_bytes + bytes > kMostWaiting) return too_much_waits();
  state_->aside_bytes += bytes;
  state_->aside.emplace_back(std::move(metadata));
  return {};
}

bool SessionWriter::ended() const { return state_->failed; }

SessionReport SessionWriter::close() {
  State& state = *state_;
  if (state.thread.joinable()) {
    state.ended = true;
    {
      const std::lock_guard lock(state.mutex);
      state.stop = true;
    }
    state.wake.notify_one();
    const bool whole = state.await_end();
    state.wake_watch.notify_all();
    state.watching.join();
    if (!whole) {
      state.thread.detach();
      const std::lock_guard lock(state.mutex);
      report_.error = Error{
          Error::Kind::refused,
          "recording: the disk does not take the rest; `palpate recording repair` makes whole what it has"};
      report_.dropped = state.drops();
      return report_;
    }
    state.thread.join();
    // What came while it ended, and what an error left.
    while (state.queue.pop([&](const Message& message) {
      state.streams[message.channel].stream->dropped_.fetch_add(1, std::memory_order_relaxed);
    })) {
    }
    report_ = state.report;
    report_.written = state.writer.statistics();
    report_.file_bytes = state.writer.file_bytes();
    const std::lock_guard lock(state.mutex);
    report_.dropped = state.drops();
  }
  return report_;
}

}  // namespace palpate::record
