#include "palpate/record/recording_copy.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <limits>

#include "palpate/record/recording_for_tests.h"
#include "palpate/record/recording_info.h"

namespace palpate::record {
namespace {

std::string repaired(const std::string& bytes, CopyReport* report = nullptr) {
  const ScratchFolder folder;
  MemorySource source(bytes);
  const auto done = repair(source, folder / "out.mcap");
  if (!done) return "";
  if (report != nullptr) *report = *done;
  return *read_file(folder / "out.mcap");
}

// At every seventh byte, for each copy waits for the disk; the reader's test takes every one.
TEST(Repair, CutOffAnywhereTheResultIsWholeAndHoldsThatManyOfTheMessages) {
  const auto bytes = small_recording();
  const auto all = lines_of(bytes);
  int refusals = 0;
  for (std::size_t size = 0; size < bytes.size(); size += 7) {
    Listener before;
    const auto damaged = scanned(bytes.substr(0, size), before);
    CopyReport report;
    const auto out = repaired(bytes.substr(0, size), &report);
    if (out.empty()) {
      ASSERT_TRUE(before.lines.empty() && before.attachments.empty() && before.metadata_of.empty()) << size;
      ++refusals;
      continue;
    }
    Listener after;
    ASSERT_TRUE(scanned(out, after).complete) << size;
    ASSERT_EQ(after.lines, before.lines) << size;
    ASSERT_EQ(after.attachments, before.attachments);
    ASSERT_EQ(after.metadata_of["session"], before.metadata_of["session"]);
    ASSERT_EQ(report.scanned.fault_count, damaged.fault_count);
    ASSERT_EQ(after.metadata_of[kRepairMetadata]["faults"], std::to_string(damaged.fault_count));
  }
  EXPECT_GT(refusals, 0);
  EXPECT_LT(refusals, 200);
}

TEST(Repair, OfASoundFileTheCopyHoldsTheSame) {
  const auto bytes = small_recording();
  CopyReport report;
  Listener listener;
  EXPECT_TRUE(scanned(repaired(bytes, &report), listener).complete);
  EXPECT_EQ(listener.lines, lines_of(bytes));
  EXPECT_TRUE(report.scanned.complete);
  EXPECT_EQ(report.scanned.lost_bytes, 0u);
}

TEST(Repair, AChunkThatIsCutOffTellsWhatWasLost) {
  const auto bytes = small_recording();
  // Chunks hold 0 to 0.4 s, 0.5 to 0.9 s and the rest.
  const std::string mark("\x04\0\0\0zstd", 8);
  const auto second = bytes.find(mark, bytes.find(mark) + 1);
  CopyReport report;
  EXPECT_FALSE(repaired(bytes.substr(0, second + 50), &report).empty());
  EXPECT_NEAR(report.scanned.lost_s, 0.5, 1e-6);
}

TEST(Repair, WhatHoldsNothingIsRefusedAndNothingIsWritten) {
  const ScratchFolder folder;
  const std::string text(5000, 'x');
  MemorySource source(text, "text.mcap");
  const auto done = repair(source, folder / "out.mcap");
  ASSERT_FALSE(done);
  EXPECT_EQ(done.error().message,
            "text.mcap: holds nothing that is sound (byte 0: does not begin as a recording in MCAP does); a "
            "recording in MCAP is expected");
  EXPECT_TRUE(std::filesystem::is_empty(folder.path()));
}

TEST(Cut, TakesTopicsAndTimesAndWhatBelongsToAll) {
  const auto bytes = small_recording();
  const ScratchFolder folder;
  MemorySource source(bytes, "small.mcap");
  const auto done = cut(source, folder / "cut.mcap", {0.2, 0.6, {"/arm/sample"}});
  ASSERT_TRUE(done) << done.error().message;
  EXPECT_EQ(done->written.messages, 3u);
  Listener listener;
  const auto result = scanned(*read_file(folder / "cut.mcap"), listener);
  EXPECT_TRUE(result.complete);
  EXPECT_EQ(result.found.channels, 1u);
  ASSERT_EQ(listener.lines.size(), 3u);
  EXPECT_EQ(listener.lines.front().data, "{\"i\":2}");
  EXPECT_EQ(listener.lines.front().schema, "palpate.Arm");
  EXPECT_EQ(listener.lines.back().data, "{\"i\":6}");
  EXPECT_EQ(listener.attachments.size(), 1u);
  EXPECT_EQ(listener.metadata_of.size(), 2u);
}

TEST(Cut, RefusesWhatIsNotWholeAndWhatLeavesNothing) {
  const auto bytes = small_recording();
  const ScratchFolder folder;
  MemorySource damaged(std::string_view(bytes).substr(0, bytes.size() - 1), "damaged.mcap"),
      sound(bytes, "small.mcap");
  const auto out = folder / "cut.mcap";
  EXPECT_NE(cut(damaged, out, {0.0, 9.0, {}}).error().message.find("palpate recording repair"),
            std::string::npos);
  EXPECT_EQ(cut(sound, out, {5.0, 9.0, {}}).error().message,
            "small.mcap: holds no message from 5 s to 9 s; it lasts 1.100 s, give other times");
  EXPECT_EQ(
      cut(sound, out, {0.0, std::numeric_limits<double>::infinity(), {"/nothing"}}).error().message,
      "small.mcap: holds no message of /nothing from 0 s to its end; it lasts 1.100 s, give other times or "
      "topics (palpate recording info lists them)");
  EXPECT_TRUE(std::filesystem::is_empty(folder.path()));
}

TEST(Info, CountsStreamsAndRates) {
  const auto bytes = small_recording();
  MemorySource source(bytes);
  const auto told = info(source);
  ASSERT_TRUE(told);
  EXPECT_NEAR(told->seconds, 1.1, 1e-9);
  ASSERT_EQ(told->streams.size(), 2u);
  EXPECT_EQ(told->streams[0].name, "/arm/sample");
  EXPECT_EQ(told->streams[0].messages, 6u);
  EXPECT_NEAR(told->streams[0].rate_hz, 5.0, 1e-9);
  const auto json = info_json(*told);
  EXPECT_EQ(json["complete"], true);
  EXPECT_EQ(json["streams"][1]["dropped"], 0);
  EXPECT_EQ(json["version"], own_library().substr(8));
  MemorySource foreign("time_s,x_mm\n");
  EXPECT_EQ(info(foreign).error().exit_code(), 2);
}

}  // namespace
}  // namespace palpate::record
