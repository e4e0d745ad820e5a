#include "palpate/record/session_writer.h"

#include <gtest/gtest.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <atomic>
#include <chrono>
#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <thread>
#include <vector>

#include "palpate/record/recorder_queue.h"
#include "palpate/record/recording_copy.h"
#include "palpate/record/recording_for_tests.h"
#include "palpate/record/recording_info.h"
#include "tests/allocation_count.h"

namespace palpate::record {
namespace {

const Schema kSchema{"palpate.Count", "jsonschema", "{}"};

std::string take_one(RecorderQueue& queue) {
  std::string data = "nothing";
  queue.pop([&](const Message& message) { data = message.data; });
  return data;
}

TEST(RecorderQueue, KeepsOrderAcrossItsEndAndForgetsNothing) {
  RecorderQueue queue(500, 100);
  std::uint32_t in = 0, out = 0;
  const auto data_of = [](std::uint32_t i) {
    return std::string(i * 7 % 90, static_cast<char>('a' + i % 26));
  };
  while (out < 5000) {
    while (queue.push({static_cast<std::uint16_t>(in), in, in * 3ull, in * 5ull, data_of(in)})) ++in;
    const auto most = out + 1 + out % 3;
    while (out < most && queue.pop([&](const Message& message) {
      ASSERT_EQ(message.sequence, out);
      ASSERT_EQ(message.channel, static_cast<std::uint16_t>(out));
      ASSERT_EQ(message.log_time_ns, out * 3ull);
      ASSERT_EQ(message.publish_time_ns, out * 5ull);
      ASSERT_EQ(message.data, data_of(out));
    }))
      ++out;
  }
}

TEST(RecorderQueue, IsBoundedByBytesAndByMessages) {
  RecorderQueue bytes(1024, 1000);
  EXPECT_FALSE(bytes.push({1, 0, 0, 0, std::string(1024, 'x')})) << "never fits";
  EXPECT_TRUE(bytes.push({1, 0, 0, 0, std::string(900, 'x')}));
  EXPECT_FALSE(bytes.push({1, 1, 0, 0, std::string(200, 'y')}));
  EXPECT_EQ(take_one(bytes), std::string(900, 'x')) << "the newest is left out";
  EXPECT_TRUE(bytes.push({1, 2, 0, 0, std::string(200, 'z')}));
  EXPECT_EQ(take_one(bytes), std::string(200, 'z'));
  EXPECT_EQ(take_one(bytes), "nothing");
  RecorderQueue messages(1'000'000, 3);
  for (int i = 0; i < 5; ++i) EXPECT_EQ(messages.push({1, 0, 0, 0, "m"}), i < 3);
}

TEST(RecorderQueue, ManyThreadsLoseNothingThatWasTaken) {
  constexpr int kThreads = 4, kEach = 20'000;
  RecorderQueue queue(8192, 64);
  std::array<std::uint32_t, kThreads> taken{}, next{};
  std::vector<std::thread> threads;
  for (std::size_t t = 0; t < kThreads; ++t)
    threads.emplace_back([&queue, &taken, t] {
      for (std::uint32_t i = 0; i < kEach; ++i) {
        const std::string data(i % 50, static_cast<char>('0' + t));
        if (queue.push({static_cast<std::uint16_t>(t), i, i, i, data})) ++taken[t];
      }
    });
  std::array<std::uint32_t, kThreads> got{};
  const auto drain = [&] {
    while (queue.pop([&](const Message& message) {
      ASSERT_GE(message.sequence, next[message.channel]) << "in the order of its thread";
      next[message.channel] = message.sequence + 1;
      ASSERT_EQ(message.data, std::string(message.sequence % 50, static_cast<char>('0' + message.channel)));
      ++got[message.channel];
    })) {
    }
  };
  for (int i = 0; i < 2000; ++i) drain();
  std::thread waiter([&threads] {
    for (auto& thread : threads) thread.join();
  });
  for (int i = 0; i < 2000; ++i) drain();
  waiter.join();
  drain();
  EXPECT_EQ(got, taken);
}

TEST(SessionWriter, WritesWhatAllThreadsGiveInTheOrderOfEach) {
  const ScratchFolder folder;
  auto session = *SessionWriter::begin(*RecordFile::growing(folder / "s.mcap"));
  auto& arm = session->add(kSchema, {"/arm", "json", 0, {}});
  auto& camera = session->add({}, {"/camera", "", 0, {}});
  ASSERT_TRUE(session->attach({kStartNs, kStartNs, "rig.toml", "application/toml", "rig"}));
  ASSERT_TRUE(session->write(Metadata{"session", {{"id", "1"}}}));
  std::thread other([&camera] {
    for (std::uint64_t i = 0; i < 50; ++i)
      EXPECT_TRUE(camera.write(kStartNs + i * 20'000'000, 0, std::string(10'000, 'p')));
  });
  for (std::uint64_t i = 0; i < 1000; ++i)
    EXPECT_TRUE(arm.write(kStartNs + i * 1'000'000, i, std::to_string(i)));
  other.join();
  const auto report = session->close();
  EXPECT_FALSE(report.error);
  EXPECT_TRUE(report.dropped.empty());
  EXPECT_EQ(report.written.messages, 1050u);
  EXPECT_FALSE(arm.write(kStartNs, 0, "after the end"));
  const auto bytes = *read_file(folder / "s.mcap");
  EXPECT_EQ(report.file_bytes, bytes.size());
  Listener listener;
  const auto result = scanned(bytes, listener);
  EXPECT_TRUE(result.complete) << first_fault(result);
  std::uint32_t next = 0;
  for (const auto& line : listener.lines)
    if (line.topic == "/arm") {
      EXPECT_EQ(line.sequence, next);
      EXPECT_EQ(line.data, std::to_string(next++));
    }
  EXPECT_EQ(next, 1000u);
  EXPECT_EQ(listener.attachments["rig.toml"], "rig");
  EXPECT_EQ(listener.metadata_of[kDropsMetadata], (Words{{"/arm", "0"}, {"/camera", "0"}}));
}

TEST(SessionWriter, CountsWhatItDropsInTheFile) {
  const ScratchFolder folder;
  SessionOptions options;
  options.queue_messages = 10;
  options.flush_every = std::chrono::milliseconds(20);
  std::vector<std::pair<DiskState, std::uint64_t>> told;  // of the watching thread, read after close()
  options.on_disk = [&told](DiskState state, std::uint64_t lost) { told.emplace_back(state, lost); };
  auto session = *SessionWriter::begin(*RecordFile::growing(folder / "s.mcap"), options);
  auto& arm = session->add(kSchema, {"/arm", "json", 0, {}});
  auto& rare = session->add(kSchema, {"/rare", "json", 0, {}});
  std::uint64_t dropped = 0, written = 0;
  // A burst faster than any disk, until some were dropped; then time for the file to tell of it.
  for (std::uint64_t i = 0; dropped < 100; ++i) (arm.write(kStartNs + i, 0, "x") ? written : dropped)++;
  std::this_thread::sleep_for(std::chrono::milliseconds(500));
  EXPECT_TRUE(rare.write(kStartNs + 1'000'000'000, 0, "r"));
  const auto report = session->close();
  EXPECT_EQ(report.dropped, (std::map<std::string, std::uint64_t>{{"/arm", dropped}}));
  ASSERT_EQ(told.size(), 1u);
  EXPECT_EQ(told[0], std::pair(DiskState::drops, dropped));
  EXPECT_EQ(arm.dropped(), dropped);
  const auto bytes = *read_file(folder / "s.mcap");
  Listener listener;
  EXPECT_TRUE(scanned(bytes, listener).complete);
  EXPECT_EQ(listener.metadata_of[kDropsMetadata]["/arm"], std::to_string(dropped));
  std::string in_file;
  for (const auto& line : listener.lines)
    if (line.topic == kDropsTopic) in_file = line.data;
  EXPECT_EQ(in_file, R"({"dropped":{"/arm":)" + std::to_string(dropped) + "}}");
  MemorySource source(bytes);
  const auto streams = info(source)->streams;
  ASSERT_EQ(streams.size(), 3u);
  EXPECT_EQ(streams[0].dropped, dropped);
  EXPECT_EQ(streams[0].messages, written);
}

// Half a second of log time from one message to the next: each is a chunk.
TEST(SessionWriter, AnHourTakesNoMoreMemoryThanTenMinutes) {
  const ScratchFolder folder;
  auto session = *SessionWriter::begin(*RecordFile::growing(folder / "s.mcap"));
  auto& arm = session->add(kSchema, {"/arm", "json", 0, {}});
  std::uint64_t count = 0;
  const auto held_after = [&](std::uint64_t messages) {
    for (; count < messages; ++count) EXPECT_TRUE(arm.write(kStartNs + count * 500'000'000, 0, "x"));
    const auto written = [&] {
      const auto bytes = read_file(folder / "s.mcap");  // not while it is written to
      return bytes ? scanned(*bytes).found.messages : 0;
    };
    // The last chunk is closed by the clock; then the writing thread holds nothing but what it keeps.
    while (written() < messages) std::this_thread::sleep_for(std::chrono::milliseconds(5));
    return held_bytes();
  };
  const auto before = held_after(1200);
  EXPECT_LE(held_after(7200), before + 100 * 1024) << "the index of 6000 chunks is five times as long";
  EXPECT_EQ(files_in(folder.path()), 1);
  EXPECT_FALSE(session->close().error);
}

TEST(SessionWriter, AFullDiskEndsTheRecordingAndDisturbsNobody) {
  std::signal(SIGXFSZ, SIG_IGN);
  rlimit before{};
  ::getrlimit(RLIMIT_FSIZE, &before);
  const ScratchFolder folder;
  std::atomic<int> errors{0};
  SessionOptions options;
  options.writer.compress = false;
  options.flush_every = std::chrono::milliseconds(10);
  options.on_error = [&](const Error& error) {
    EXPECT_NE(error.message.find("writing failed (File too large)"), std::string::npos) << error.message;
    ++errors;
  };
  auto session = *SessionWriter::begin(*RecordFile::growing(folder / "s.mcap"), options);
  auto& arm = session->add(kSchema, {"/arm", "json", 0, {}});
  const rlimit low{1'000'000, before.rlim_max};
  ::setrlimit(RLIMIT_FSIZE, &low);
  std::uint64_t i = 0;
  for (; errors == 0; ++i) {
    arm.write(kStartNs + i * 1'000'000, 0, std::string(200, 'x'));
    if (i % 10 == 0) std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  for (int k = 0; k < 1000; ++k) EXPECT_FALSE(arm.write(kStartNs, 0, "goes on"));
  EXPECT_TRUE(session->ended());
  const auto report = session->close();
  ::setrlimit(RLIMIT_FSIZE, &before);
  EXPECT_EQ(errors, 1);
  ASSERT_TRUE(report.error);
  EXPECT_GE(report.dropped.at("/arm"), 1000u);
  Listener listener;
  const auto result = scanned(*read_file(folder / "s.mcap"), listener);
  EXPECT_FALSE(result.complete);
  EXPECT_EQ(result.lost_bytes, 0u) << "ends with a whole record";
  EXPECT_GT(listener.lines.size(), 100u);
}

// A child records at 1 kHz until it is killed; its log times are those of the machine's clock, as ours here.
std::uint64_t now_ns() {
  return static_cast<std::uint64_t>(std::chrono::duration_cast<std::chrono::nanoseconds>(
                                        std::chrono::steady_clock::now().time_since_epoch())
                                        .count());
}

[[noreturn]] void record_until_killed(const std::filesystem::path& path) {
  auto session = SessionWriter::begin(*RecordFile::growing(path));
  auto& arm = (*session)->add(kSchema, {"/arm", "json", 0, {}});
  for (;;) {
    arm.write(now_ns(), 0, "{\"joints\":[0.1,0.2,0.3]}");
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
}

TEST(SessionWriter, KilledAtAnyMomentItLosesAtMostASecond) {
  for (const int lived_ms : {0, 230, 490, 777, 1460}) {  // after its first chunk
    const ScratchFolder folder;
    const auto path = folder / "killed.mcap";
    const pid_t child = ::fork();
    ASSERT_GE(child, 0);
    if (child == 0) record_until_killed(path);
    const auto begun = [&] {
      std::error_code none;
      const auto size = std::filesystem::file_size(path, none);
      return !none && size > 500;
    };
    while (!begun()) std::this_thread::sleep_for(std::chrono::milliseconds(1));
    std::this_thread::sleep_for(std::chrono::milliseconds(lived_ms));
    ::kill(child, SIGKILL);
    const auto killed_ns = now_ns();
    ASSERT_EQ(::waitpid(child, nullptr, 0), child);
    EXPECT_EQ(files_in(folder.path()), 1) << "nothing is left beside it";
    const auto bytes = *read_file(path);
    MemorySource source(bytes);
    const auto done = repair(source, folder / "repaired.mcap");
    ASSERT_TRUE(done) << done.error().message;
    Listener listener;
    const auto result = scanned(*read_file(folder / "repaired.mcap"), listener);
    EXPECT_TRUE(result.complete) << first_fault(result);
    ASSERT_FALSE(listener.lines.empty());
    EXPECT_LT(1e-9 * static_cast<double>(killed_ns - listener.lines.back().log_time_ns), 1.0) << lived_ms;
    EXPECT_EQ(listener.lines.back().sequence + 1, listener.lines.size()) << "none is missing before";
  }
}

}  // namespace
}  // namespace palpate::record
