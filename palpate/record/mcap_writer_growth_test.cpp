// What a long recording keeps, and where: its index of chunks waits for the end in a file without a name.
#include <fcntl.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <memory>
#include <string>

#include "palpate/core/part_file.h"
#include "palpate/record/mcap_writer.h"
#include "palpate/record/recording_copy.h"
#include "palpate/record/recording_for_tests.h"
#include "palpate/record/recording_info.h"
#include "tests/allocation_count.h"

namespace palpate::record {
namespace {

namespace fs = std::filesystem;

constexpr std::uint64_t kChunkNs = 500'000'000;

// One message in each chunk, of three channels in turn.
class LongRecording {
 public:
  explicit LongRecording(const fs::path& path, bool room_for_its_index = true) {
    WriterOptions options;
    options.compress = false;
    auto file = RecordFile::growing(path);
    rlimit before{};
    ::getrlimit(RLIMIT_NOFILE, &before);
    const rlimit none{0, before.rlim_max};
    if (!room_for_its_index) ::setrlimit(RLIMIT_NOFILE, &none);
    writer_ = std::make_unique<McapWriter>(*McapWriter::begin(std::move(*file), options));
    ::setrlimit(RLIMIT_NOFILE, &before);
    for (const char* topic : {"/a", "/b", "/c"}) EXPECT_TRUE(writer_->add_channel({topic, "json", 0, {}}));
  }
  Expected<void> write(std::uint32_t messages) {
    Expected<void> done;
    for (const auto end = count_ + messages; done && count_ < end; ++count_)
      done = writer_->write(
          Message{static_cast<std::uint16_t>(1 + count_ % 3), count_, kStartNs + kChunkNs * count_, 0, "{}"});
    return done;
  }
  McapWriter& writer() { return *writer_; }

 private:
  std::unique_ptr<McapWriter> writer_;
  std::uint32_t count_ = 0;
};

// Whatever this process has opened in the folder, and what has no name there: the index.
int index_in(const fs::path& folder) {
  for (const auto& entry : fs::directory_iterator("/proc/self/fd")) {
    std::error_code gone;
    const std::string link = fs::read_symlink(entry.path(), gone).string();
    if (link.starts_with(folder.string() + "/") && link.ends_with(" (deleted)"))
      return std::stoi(entry.path().filename().string());
  }
  return -1;
}

// From now on that is what stands there.
void put_in_place_of(int fd, const char* device) {
  const FileDescriptor other(::open(device, O_RDWR | O_CLOEXEC));
  ASSERT_EQ(::dup3(other.get(), fd, O_CLOEXEC), fd);
}

TEST(McapWriterGrowth, TenThousandChunksTakeNoMoreMemoryThanAThousand) {
  const ScratchFolder folder;
  LongRecording recording(folder / "long.mcap");
  ASSERT_TRUE(recording.write(1000));
  const std::size_t before = held_bytes();
  ASSERT_TRUE(recording.write(9000));
  EXPECT_LE(held_bytes(), before + 64 * 1024) << "the index of 9000 chunks is ten times as long";
  EXPECT_EQ(files_in(folder.path()), 1) << "and has no name";
  ASSERT_TRUE(recording.writer().close());
  EXPECT_EQ(files_in(folder.path()), 1);
  const auto result = scanned(*read_file(folder / "long.mcap"));
  EXPECT_TRUE(result.complete) << first_fault(result);
  EXPECT_EQ(result.found.chunks, 10'000u);
}

TEST(McapWriterGrowth, WhereNoFileCanBeMadeTheBytesAreTheSame) {
  const ScratchFolder folder;
  // The undefined-behaviour sanitizer needs a descriptor of its own when it meets a type for the first time.
  ASSERT_TRUE(PartFile::begin(folder / "before"));
  for (const bool room : {true, false}) {
    LongRecording recording(folder / (room ? "spilled.mcap" : "kept.mcap"), room);
    EXPECT_EQ(index_in(folder.path()) >= 0, room);
    ASSERT_TRUE(recording.write(3000));
    ASSERT_TRUE(recording.writer().close());
  }
  EXPECT_EQ(*read_file(folder / "spilled.mcap"), *read_file(folder / "kept.mcap"));
}

void expect_all_but_the_summary(const fs::path& file, std::size_t messages) {
  const auto bytes = *read_file(file);
  Listener listener;
  const auto result = scanned(bytes, listener);
  EXPECT_FALSE(result.complete);
  EXPECT_EQ(result.lost_bytes, 0u) << "ends with a whole record";
  EXPECT_EQ(listener.lines.size(), messages);
  MemorySource source(bytes);
  const auto repaired = repair(source, file.parent_path() / "repaired.mcap");
  ASSERT_TRUE(repaired) << repaired.error().message;
  EXPECT_EQ(repaired->written.messages, messages);
}

TEST(McapWriterGrowth, AnIndexThatTheDiskRefusesIsToldAndLosesNothing) {
  const ScratchFolder folder;
  LongRecording recording(folder / "s.mcap");
  put_in_place_of(index_in(folder.path()), "/dev/full");
  const auto done = recording.write(3000);
  ASSERT_FALSE(done);
  EXPECT_NE(done.error().message.find("writing its index aside failed (No space left"), std::string::npos)
      << done.error().message;
  EXPECT_FALSE(recording.write(1)) << "and again by each later call";
  EXPECT_FALSE(recording.writer().close());
  expect_all_but_the_summary(folder / "s.mcap", recording.writer().statistics().messages);
}

TEST(McapWriterGrowth, AnIndexThatCannotBeReadIsToldAndLosesNothing) {
  const ScratchFolder folder;
  LongRecording recording(folder / "s.mcap");
  ASSERT_TRUE(recording.write(3000));
  put_in_place_of(index_in(folder.path()), "/dev/null");
  const auto done = recording.writer().close();
  ASSERT_FALSE(done);
  EXPECT_NE(done.error().message.find("reading its index failed"), std::string::npos) << done.error().message;
  expect_all_but_the_summary(folder / "s.mcap", 3000);
}

TEST(McapWriterGrowth, ADiskThatIsFullInTheMiddleOfTheSummaryLosesNothing) {
  const ScratchFolder folder;
  LongRecording recording(folder / "s.mcap");
  ASSERT_TRUE(recording.write(3000));
  ASSERT_TRUE(recording.writer().flush());
  const auto data_bytes = recording.writer().file_bytes();
  {
    const FileLimit limit(data_bytes + 100'000);  // the index alone is more than 200 kB
    EXPECT_FALSE(recording.writer().close());
  }
  EXPECT_LT(fs::file_size(folder / "s.mcap"), data_bytes + 50) << "only the end of the data came behind";
  expect_all_but_the_summary(folder / "s.mcap", 3000);
}

}  // namespace
}  // namespace palpate::record
