#include "palpate/record/mcap_writer.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <stdexcept>

#include "palpate/record/internal/crc32.h"
#include "palpate/record/recording_for_tests.h"

namespace palpate::record {
namespace {

// As the definition says it, a bit at a time.
std::uint32_t slow_crc(std::string_view bytes) {
  std::uint32_t crc = 0xFFFFFFFFu;
  for (const unsigned char byte : bytes) {
    crc ^= byte;
    for (int i = 0; i < 8; ++i) crc = (crc >> 1) ^ (0xEDB88320u & (0u - (crc & 1u)));
  }
  return ~crc;
}

TEST(Crc32, KnownValueAndPiecesOfAnySize) {
  EXPECT_EQ(crc32("123456789"), 0xCBF43926u);
  std::string text;
  for (int i = 0; i < 100; ++i) text += static_cast<char>(i * 37);
  for (std::size_t cut = 0; cut <= text.size(); ++cut) {
    EXPECT_EQ(crc32(text.substr(0, cut)), slow_crc(text.substr(0, cut)));
    EXPECT_EQ(crc32(text.substr(cut), crc32(text.substr(0, cut))), slow_crc(text));
  }
}

std::string u(std::uint64_t value, int bytes) {
  std::string out;
  for (int i = 0; i < bytes; ++i) out += static_cast<char>(value >> (8 * i));
  return out;
}
std::string text(std::string_view words) { return u(words.size(), 4) + std::string(words); }
std::string record(int opcode, const std::string& content) {
  return u(static_cast<unsigned>(opcode), 1) + u(content.size(), 8) + content;
}

// The format's own words, byte for byte, without our encoders.
TEST(McapWriter, ATinyFileHasTheseBytes) {
  const std::string magic("\x89MCAP0\r\n", 8);
  const std::string channel = record(4, u(1, 2) + u(0, 2) + text("/t") + text("e") + u(0, 4));
  const std::string message = record(5, u(1, 2) + u(9, 4) + u(1000, 8) + u(900, 8) + "ab");
  const std::string inside = channel + message;
  const std::string chunk = record(6, u(1000, 8) + u(1000, 8) + u(inside.size(), 8) + u(slow_crc(inside), 4) +
                                          text("") + u(inside.size(), 8) + inside);
  const std::string index = record(7, u(1, 2) + u(16, 4) + u(1000, 8) + u(channel.size(), 8));
  std::string expected = magic + record(1, text("p") + text("l")) + channel;
  const auto chunk_at = expected.size();
  expected += chunk + index;
  expected += record(15, u(slow_crc(expected), 4));
  const auto begin = expected.size();
  const auto statistics = record(11, u(1, 8) + u(0, 2) + u(1, 4) + u(0, 4) + u(0, 4) + u(1, 4) + u(1000, 8) +
                                         u(1000, 8) + u(10, 4) + u(1, 2) + u(1, 8));
  const auto chunk_index =
      record(8, u(1000, 8) + u(1000, 8) + u(chunk_at, 8) + u(chunk.size(), 8) + u(10, 4) + u(1, 2) +
                    u(chunk_at + chunk.size(), 8) + u(index.size(), 8) + text("") + u(inside.size(), 8) +
                    u(inside.size(), 8));
  std::string summary = channel + statistics + chunk_index;
  const auto offsets = begin + summary.size();
  summary += record(14, u(4, 1) + u(begin, 8) + u(channel.size(), 8));
  summary += record(14, u(11, 1) + u(begin + channel.size(), 8) + u(statistics.size(), 8));
  summary +=
      record(14, u(8, 1) + u(begin + channel.size() + statistics.size(), 8) + u(chunk_index.size(), 8));
  summary += u(2, 1) + u(20, 8) + u(begin, 8) + u(offsets, 8);
  expected += summary + u(slow_crc(summary), 4) + magic;

  const ScratchFolder folder;
  WriterOptions options;
  options.header = {"p", "l"};
  options.compress = false;
  auto writer = McapWriter::begin(*RecordFile::growing(folder / "tiny.mcap"), options);
  ASSERT_TRUE(writer);
  EXPECT_EQ(*writer->add_channel({"/t", "e", 0, {}}), 1);
  ASSERT_TRUE(writer->write(Message{1, 9, 1000, 900, "ab"}));
  ASSERT_TRUE(writer->close());
  EXPECT_EQ(*read_file(folder / "tiny.mcap"), expected);
  EXPECT_TRUE(scanned(expected).complete);
}

TEST(McapWriter, WhatWasWrittenIsRead) {
  for (const bool compress : {true, false}) {
    SmallRecording what;
    what.options.compress = compress;
    const auto bytes = small_recording(what);
    Listener listener;
    const auto result = scanned(bytes, listener);
    EXPECT_TRUE(result.complete) << result.faults.size();
    ASSERT_EQ(listener.lines.size(), 12u);
    for (std::size_t i = 0; i < 12; ++i)
      EXPECT_EQ(listener.lines[i],
                (HeardLine{i % 2 == 0 ? "/arm/sample" : "/plain", i % 2 == 0 ? "palpate.Arm" : "",
                           "{\"i\":" + std::to_string(i) + "}", static_cast<std::uint32_t>(i / 2),
                           kStartNs + 100'000'000 * i}));
    EXPECT_EQ(listener.attachments["rig.toml"], "name = \"rig\"\n");
    EXPECT_EQ(listener.metadata_of["session"], (Words{{"id", "7"}, {"who", "nobody"}}));
    EXPECT_EQ(result.header.library.substr(0, 8), "palpate ");
    EXPECT_EQ(result.found.chunks, 3u) << "one for each half of a second";
    EXPECT_EQ(result.found.messages_of_channels, (std::map<std::uint16_t, std::uint64_t>{{1, 6}, {2, 6}}));
  }
}

TEST(McapWriter, TheSameCallsGiveTheSameBytes) { EXPECT_EQ(small_recording(), small_recording()); }

TEST(McapWriter, AChunkEndsByItsSizeAndByALongMessage) {
  SmallRecording what;
  what.options.chunk_bytes = 1200;
  what.options.chunk_time = std::chrono::hours(1);
  what.padding = 450;
  EXPECT_EQ(scanned(small_recording(what)).found.chunks, 6u);  // two messages fit
  what.padding = 5000;
  EXPECT_EQ(scanned(small_recording(what)).found.chunks, 12u);
}

TEST(McapWriter, WrongUseThrowsAndHugeMessagesAreRefused) {
  const ScratchFolder folder;
  auto writer = McapWriter::begin(*RecordFile::growing(folder / "wrong.mcap"));
  EXPECT_THROW((void)writer->write(Message{1, 0, 0, 0, ""}), std::invalid_argument);
  EXPECT_THROW((void)writer->add_channel({"/t", "", 3, {}}), std::invalid_argument);
  const auto channel = *writer->add_channel({"/t", "", 0, {}});
  const std::string huge(kMostMessageBytes + 1, 'x');
  EXPECT_FALSE(writer->write(Message{channel, 0, 0, 0, huge}));
  EXPECT_TRUE(writer->write(Message{channel, 0, 0, 0, "small"}));
  EXPECT_TRUE(writer->close());
}

TEST(RecordFile, WhatIsThereIsReplacedOnlyWhenAskedAndOnlyAPlainFile) {
  const ScratchFolder folder;
  const auto path = folder / "there.mcap";
  ASSERT_TRUE(write_file(path, "before"));
  const auto refused = RecordFile::growing(path);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().exit_code(), 2);
  EXPECT_EQ(*read_file(path), "before");
  EXPECT_TRUE(RecordFile::growing(path, Existing::replace));
  EXPECT_EQ(*read_file(path), "");
  std::filesystem::create_symlink(path, folder / "link");
  std::filesystem::create_directory(folder / "folder");
  for (const auto& other : {folder / "link", folder / "folder", std::filesystem::path("/dev/full")})
    EXPECT_FALSE(RecordFile::growing(other, Existing::replace)) << other;
  EXPECT_FALSE(RecordFile::growing(folder / "nowhere" / "new.mcap"));
  EXPECT_FALSE(RecordFile::whole("/dev/full"));
}

TEST(RecordFile, AWholeFileAppearsAtItsEnd) {
  const ScratchFolder folder;
  {
    auto file = RecordFile::whole(folder / "whole");
    ASSERT_TRUE(file->append("abc"));
    EXPECT_FALSE(is_there(folder / "whole"));
    ASSERT_TRUE(file->finish());
  }
  EXPECT_EQ(*read_file(folder / "whole"), "abc");
  { ASSERT_TRUE(RecordFile::whole(folder / "whole")->append("xyz")); }
  EXPECT_EQ(*read_file(folder / "whole"), "abc") << "never finished";
  EXPECT_EQ(files_in(folder.path()), 1);
}

TEST(McapWriter, AFullDiskIsToldAndLeavesWholeRecords) {
  const ScratchFolder folder;
  WriterOptions options;
  options.chunk_bytes = 1000;
  options.compress = false;
  auto writer = McapWriter::begin(*RecordFile::growing(folder / "full.mcap"), options);
  const auto channel = *writer->add_channel({"/t", "", 0, {}});
  const std::string data(300, 'x');
  Expected<void> done;
  {
    const FileLimit limit(5000);
    for (std::uint32_t i = 0; done && i < 1000; ++i) done = writer->write(Message{channel, i, i, i, data});
  }
  ASSERT_FALSE(done);
  EXPECT_NE(done.error().message.find("File too large"), std::string::npos) << done.error().message;
  EXPECT_FALSE(writer->write(Message{channel, 0, 0, 0, data})) << "and again by each later call";
  EXPECT_FALSE(writer->close());
  Listener listener;
  const auto result = scanned(*read_file(folder / "full.mcap"), listener);
  EXPECT_FALSE(result.complete);
  EXPECT_EQ(result.lost_bytes, 0u);
  EXPECT_GE(listener.lines.size(), 8u);
}

}  // namespace
}  // namespace palpate::record
