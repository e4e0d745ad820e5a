#include "palpate/record/mcap_reader.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>

#include "palpate/record/internal/compression.h"
#include "palpate/record/internal/crc32.h"
#include "palpate/record/internal/mcap_records.h"
#include "palpate/record/recording_for_tests.h"

namespace palpate::record {
namespace {

bool is_prefix(const std::vector<HeardLine>& part, const std::vector<HeardLine>& all) {
  return part.size() <= all.size() && std::equal(part.begin(), part.end(), all.begin());
}

// Whether `part` is what is left of `all` when some are taken out.
bool is_left_of(const std::vector<HeardLine>& part, const std::vector<HeardLine>& all) {
  std::size_t at = 0;
  for (const auto& line : all)
    if (at < part.size() && part[at] == line) ++at;
  return at == part.size();
}

TEST(McapReader, CutOffAtAnyByteItGivesThatManyOfTheMessages) {
  const auto bytes = small_recording();
  const auto all = lines_of(bytes);
  std::size_t most = 0;
  for (std::size_t size = 0; size < bytes.size(); ++size) {
    Listener listener;
    const auto result = scanned(bytes.substr(0, size), listener);
    ASSERT_FALSE(result.complete) << size;
    ASSERT_GE(result.fault_count, 1u) << size;
    ASSERT_TRUE(is_prefix(listener.lines, all)) << size;
    ASSERT_GE(listener.lines.size(), most) << "more of the file, more of its messages: " << size;
    most = listener.lines.size();
    ASSERT_EQ(result.found.messages, listener.lines.size());
  }
  EXPECT_EQ(most, all.size());
}

TEST(McapReader, NoByteChangesUnnoticed) {
  const auto bytes = small_recording();
  const auto all = lines_of(bytes);
  for (std::size_t at = 0; at < bytes.size(); ++at)
    for (const int flip : {0x01, 0x40, 0xFF}) {
      auto changed = bytes;
      changed[at] = static_cast<char>(changed[at] ^ flip);
      Listener listener;
      const auto result = scanned(changed, listener);
      ASSERT_FALSE(result.complete) << at;
      ASSERT_GE(result.fault_count, 1u) << at;
      const bool ours = std::all_of(listener.lines.begin(), listener.lines.end(), [&](const HeardLine& line) {
        return std::find(all.begin(), all.end(), line) != all.end();
      });
      ASSERT_TRUE(ours && is_left_of(listener.lines, all)) << at << " ^ " << flip;
    }
}

// Then no CRC of the whole helps.
TEST(McapReader, NoByteOfACutOffFileGivesWrongMessagesUnnoticed) {
  const auto whole = small_recording();
  const auto bytes = whole.substr(0, whole.find("session") - 13);  // behind the chunk before the metadata
  Listener sound;
  (void)scanned(bytes, sound);
  ASSERT_GE(sound.lines.size(), 5u);
  const auto faults = scanned(bytes).fault_count;
  for (std::size_t at = 0; at < bytes.size(); ++at)
    for (const int flip : {0x01, 0x03, 0x40, 0xFF}) {
      auto changed = bytes;
      changed[at] = static_cast<char>(changed[at] ^ flip);
      Listener listener;
      const auto result = scanned(changed, listener);
      if (listener.lines != sound.lines) {
        ASSERT_GT(result.fault_count + result.lost_bytes, faults) << at << " ^ " << flip;
      }
    }
}

TEST(McapReader, GoesOnBehindADamagedChunkAndBehindADamagedLength) {
  SmallRecording what;
  what.messages = 40;
  const auto bytes = small_recording(what);
  const auto all = lines_of(bytes);
  std::vector<std::size_t> chunks;
  for (auto at = bytes.find(std::string("\x04\0\0\0zstd\0", 8)); at != std::string::npos && chunks.size() < 8;
       at = bytes.find(std::string("\x04\0\0\0zstd\0", 8), at + 1))
    chunks.push_back(at - 37);
  ASSERT_EQ(chunks.size(), 8u);
  auto damaged = bytes;
  damaged[chunks[3] + 70] ^= 1;    // in what is packed
  damaged[chunks[5] + 4] ^= 0x55;  // in its length
  Listener listener;
  const auto result = scanned(damaged, listener);
  EXPECT_TRUE(is_left_of(listener.lines, all));
  EXPECT_EQ(listener.lines.size(), 30u);
  EXPECT_EQ(result.lost_chunks, 1u);
  EXPECT_NEAR(result.lost_s, 1.2, 1e-6) << "twice from the last sound message to the next one";
  ScanOptions strict;
  strict.tolerant = false;
  Listener first;
  const auto ended = scanned(damaged, first, strict);
  EXPECT_EQ(ended.fault_count, 1u);
  EXPECT_EQ(ended.faults.front().offset, chunks[3]);
  EXPECT_EQ(ended.faults.front().words, "Chunk: its CRC is wrong");
  EXPECT_EQ(first.lines.size(), 15u);
}

TEST(McapReader, TopicsAndTimesChooseMessages) {
  const auto bytes = small_recording();
  ScanOptions options;
  options.topics = {"/plain"};
  options.from_ns = kStartNs + 300'000'000;
  options.to_ns = kStartNs + 700'000'000;
  Listener listener;
  const auto result = scanned(bytes, listener, options);
  EXPECT_TRUE(result.complete);
  EXPECT_EQ(result.found.messages, 12u) << "all are counted";
  ASSERT_EQ(listener.lines.size(), 3u);
  EXPECT_EQ(listener.lines.front().data, "{\"i\":3}");
  EXPECT_EQ(listener.lines.back().data, "{\"i\":7}");
}

TEST(McapReader, AHandlerThatRefusesEndsTheScan) {
  struct Refuses : ScanHandler {
    Expected<void> message(const HeardMessage&) override { return refused("enough; less is expected"); }
  } handler;
  const auto bytes = small_recording();
  MemorySource source(bytes);
  const auto result = scan(source, {}, handler);
  ASSERT_FALSE(result);
  EXPECT_EQ(result.error().message, "enough; less is expected");
}

// A file of one chunk, with whatever it says of itself.
std::string file_of(const ChunkHead& chunk) {
  std::string bytes(kMagic);
  append_header(bytes, {"", "others"});
  append_chunk(bytes, chunk);
  append_data_end(bytes, 0);
  RecordBytes(bytes, Opcode::footer)
      .number(std::uint64_t{0})
      .number(std::uint64_t{0})
      .number(std::uint32_t{0})
      .finish();
  return bytes + std::string(kMagic);
}

std::string one_message() {
  std::string records;
  append_channel(records, 7, {"/t", "", 0, {}});
  append_message(records, {7, 1, 50, 50, "data"});
  return records;
}

TEST(McapReader, ReadsFilesWithoutSummaryIndexOrCrc) {
  const auto records = one_message();
  Listener listener;
  const auto result = scanned(file_of({50, 50, records.size(), 0, "", records}), listener);
  EXPECT_TRUE(result.complete) << result.faults.front().words;
  ASSERT_EQ(listener.lines.size(), 1u);
  EXPECT_EQ(listener.lines.front().data, "data");
}

TEST(McapReader, SizesThatLieTakeNoMemory) {
  const auto records = one_message();
  Compressor compressor;
  const std::string packed(compressor.compress(records));
  for (const std::uint64_t size : {std::uint64_t{0}, records.size() - 1, records.size() + 1, kMostChunkBytes,
                                   kMostChunkBytes + 1, ~std::uint64_t{0}}) {
    Listener listener;
    const auto result = scanned(file_of({50, 50, size, 0, "zstd", packed}), listener);
    EXPECT_EQ(result.lost_chunks, 1u) << size;
    EXPECT_TRUE(listener.lines.empty());
  }
  // Lengths of every record and text of a file beyond all that there is.
  const auto bytes = small_recording();
  for (std::size_t at = 0; at + 8 <= bytes.size(); ++at) {
    auto changed = bytes;
    changed.replace(at, 8, "\xFF\xFF\xFF\xFF\xFF\xFF\xFF\x7F");
    EXPECT_FALSE(scanned(changed).complete) << at;
  }
}

TEST(McapReader, WhatOthersPackIsNamed) {
  const auto records = one_message();
  ScanHandler nobody;
  const auto bytes = file_of({50, 50, records.size(), 0, "lz4", records});
  MemorySource source(bytes, "others.mcap");
  const auto result = scan(source, {}, nobody);
  ASSERT_FALSE(result);
  EXPECT_EQ(result.error().message,
            "others.mcap: its chunks are packed with lz4, which is not read here; zstd or none is expected, "
            "pack it anew");
  EXPECT_EQ(scanned(file_of({50, 50, records.size(), 0, "brotli", records})).faults.front().words,
            "Chunk: is packed with 'brotli'; zstd or none is expected");
}

TEST(McapReader, UnknownRecordsArePassedOver) {
  std::string records = one_message();
  RecordBytes(records, static_cast<Opcode>(0x91)).text("inside").finish();
  auto bytes = file_of({50, 50, records.size(), crc32(records), "", records});
  std::string unknown;
  RecordBytes(unknown, static_cast<Opcode>(0x42)).text(std::string(600'000, 'x')).finish();
  bytes.insert(bytes.size() - 8 - 29 - 13, unknown);
  Listener listener;
  EXPECT_TRUE(scanned(bytes, listener).complete);
  EXPECT_EQ(listener.lines.size(), 1u);
}

TEST(McapReader, MessagesOfNoChannelAndChunksInChunksAreFaults) {
  std::string records = one_message();
  append_message(records, {8, 1, 50, 50, "of nobody"});
  append_chunk(records, {});
  Listener listener;
  const auto result = scanned(file_of({50, 50, records.size(), 0, "", records}), listener);
  EXPECT_EQ(listener.lines.size(), 1u);
  ASSERT_EQ(result.fault_count, 2u);
  EXPECT_EQ(result.faults[0].words, "Message: of channel 8, of which nothing was told");
  EXPECT_EQ(result.faults[1].words, "Chunk: has no place in a chunk");
}

// A large chunk, and small records about it by the thousand.
TEST(McapReader, AFileFullOfIndexesIsDoneSoon) {
  std::string records = one_message();
  for (int i = 0; i < 500'000; ++i) append_message(records, {7, 1, 50, 50, ""});
  std::string bytes(kMagic);
  append_header(bytes, {"", "others"});
  append_chunk(bytes, {50, 50, records.size(), 0, "", records});
  for (int i = 0; i < 20'000; ++i) append_message_index(bytes, 7, {});
  const auto begin = std::chrono::steady_clock::now();
  EXPECT_EQ(scanned(bytes).fault_count, 20'001u);
  EXPECT_LT(std::chrono::steady_clock::now() - begin, std::chrono::seconds(20));
}

// Marks of chunks wherever one looks: work in proportion to the file.
TEST(McapReader, AFileFullOfFalseChunksIsDoneSoon) {
  std::string bytes(kMagic);
  bytes += std::string(1, '\0');
  std::string head = "\x06";
  append_little_endian(head, std::uint64_t{100'000 + 44});
  head += std::string(28, '\1') + std::string("\x04\0\0\0zstd", 8);
  append_little_endian(head, std::uint64_t{100'000});
  for (int i = 0; i < 40'000; ++i) bytes += head;
  const auto begin = std::chrono::steady_clock::now();
  EXPECT_EQ(scanned(bytes).found.messages, 0u);
  EXPECT_LT(std::chrono::steady_clock::now() - begin, std::chrono::seconds(20));
}

}  // namespace
}  // namespace palpate::record
