#include "palpate/record/recording_merge.h"

#include <algorithm>

#include "palpate/record/recording_for_tests.h"

namespace palpate::record {
namespace {

std::filesystem::path write(const ScratchFolder& folder, const std::string& name, const std::string& bytes) {
  EXPECT_TRUE(write_file(folder / name, bytes));
  return folder / name;
}

// A recording with messages at these times, numbered from 0 on but for what was dropped.
std::string recording_at(const std::string& topic,
                         const std::vector<std::pair<std::uint32_t, std::uint64_t>>& messages) {
  const ScratchFolder folder;
  auto writer = McapWriter::begin(*RecordFile::growing(folder / "part.mcap"));
  const auto channel = *writer->add_channel({topic, "json", 0, {}});
  for (const auto& [sequence, time] : messages)
    EXPECT_TRUE(writer->write(Message{channel, sequence, time, time, "{}"}));
  EXPECT_TRUE(writer->attach({1, 1, "rig.toml", "application/toml", "rig"}));
  EXPECT_TRUE(writer->close());
  return *read_file(folder / "part.mcap");
}

TEST(RecordingMerge, MessagesComeInTheOrderOfTheirTimes) {
  const ScratchFolder folder;
  const auto a = write(folder, "a.mcap", recording_at("/a", {{0, 10}, {1, 30}, {2, 50}}));
  const auto b = write(folder, "b.mcap", recording_at("/b", {{0, 20}, {1, 30}, {2, 60}}));
  const auto merged = merge({a, b}, folder / "both.mcap");
  ASSERT_TRUE(merged) << merged.error().message;
  EXPECT_EQ(merged->messages, 6u);
  EXPECT_EQ(merged->attachments, 1u) << "the same file stands there once";
  const auto lines = lines_of(*read_file(folder / "both.mcap"));
  std::vector<std::uint64_t> times;
  for (const auto& line : lines) times.push_back(line.log_time_ns);
  EXPECT_EQ(times, (std::vector<std::uint64_t>{10, 20, 30, 30, 50, 60}));
}

TEST(RecordingMerge, OfATopicInCommonNumbersGoOnAndGapsRemain) {
  const ScratchFolder folder;
  const auto a = write(folder, "a.mcap", recording_at("/tf", {{0, 10}, {3, 30}}));  // two are missing
  const auto b = write(folder, "b.mcap", recording_at("/tf", {{0, 20}, {1, 40}}));
  ASSERT_TRUE(merge({a, b}, folder / "both.mcap"));
  std::vector<std::uint32_t> numbers;
  for (const auto& line : lines_of(*read_file(folder / "both.mcap"))) numbers.push_back(line.sequence);
  EXPECT_EQ(numbers, (std::vector<std::uint32_t>{0, 1, 4, 5}));
}

// Much more than a feed holds, of very different lengths.
TEST(RecordingMerge, LongOnesMeetWithoutWaitingForEver) {
  const ScratchFolder folder;
  std::vector<std::pair<std::uint32_t, std::uint64_t>> many, few{{0, 5}, {1, 999'999'999}};
  for (std::uint32_t i = 0; i < 20'000; ++i) many.emplace_back(i, 10 + 3ull * i);
  const auto a = write(folder, "a.mcap", recording_at("/a", many));
  const auto b = write(folder, "b.mcap", recording_at("/b", few));
  const auto merged = merge({a, b, a}, folder / "all.mcap");
  ASSERT_TRUE(merged) << merged.error().message;
  EXPECT_EQ(merged->messages, 40'002u);
  const auto lines = lines_of(*read_file(folder / "all.mcap"));
  EXPECT_TRUE(std::is_sorted(lines.begin(), lines.end(),
                             [](const auto& x, const auto& y) { return x.log_time_ns < y.log_time_ns; }));
}

TEST(RecordingMerge, WhatIsNotWholeIsRefusedAndNothingIsLeft) {
  const ScratchFolder folder;
  const auto whole = write(folder, "a.mcap", small_recording());
  const auto cut_off = write(folder, "b.mcap", small_recording().substr(0, 300));
  const auto refusal = merge({whole, cut_off}, folder / "both.mcap");
  ASSERT_FALSE(refusal);
  EXPECT_NE(refusal.error().message.find("repair"), std::string::npos) << refusal.error().message;
  EXPECT_FALSE(std::filesystem::exists(folder / "both.mcap"));
  EXPECT_FALSE(merge({whole, folder / "nowhere.mcap"}, folder / "both.mcap"));
}

}  // namespace
}  // namespace palpate::record
