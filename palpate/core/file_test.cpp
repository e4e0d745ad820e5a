#include "palpate/core/file.h"

#include <gtest/gtest.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <atomic>
#include <chrono>
#include <fstream>
#include <thread>
#include <vector>

#include "palpate/core/csv_file.h"
#include "palpate/core/json.h"
#include "tests/scratch_folder.h"

namespace palpate::inline core {
namespace {

namespace fs = std::filesystem;

TEST(File, ComesBackAsWritten) {
  const ScratchFolder scratch;
  const auto path = scratch / "whole";
  ASSERT_TRUE(write_file(path, "first").has_value());
  ASSERT_TRUE(write_file(path, "second").has_value());
  EXPECT_EQ(read_file(path).value(), "second");
}

TEST(File, IsTheSameByAnotherName) {
  const ScratchFolder folder;
  const fs::path file = folder / "a.txt";
  EXPECT_TRUE(same_file(file, folder / "." / "b" / ".." / "a.txt")) << "not there yet";
  EXPECT_FALSE(same_file(file, folder / "b.txt"));
  ASSERT_TRUE(write_file(file, "a"));
  fs::create_symlink(file, folder / "link");
  EXPECT_TRUE(same_file(file, folder / "link"));
}

TEST(File, AFullDiskIsSaidAndNothingIsLeft) {
  if (!fs::exists("/dev/full")) GTEST_FAIL() << "this test needs /dev/full";
  const auto written = write_file("/dev/full", "text");
  ASSERT_FALSE(written.has_value());
  EXPECT_NE(written.error().message.find("No space left"), std::string::npos);
}

TEST(File, AMissingFolderIsWrongUse) {
  const ScratchFolder scratch;
  const auto written = write_file(scratch / "no-folder" / "a.json", "text");
  ASSERT_FALSE(written.has_value());
  EXPECT_EQ(written.error().exit_code(), 2);
}

TEST(File, AMissingFileIsWrongUse) {
  EXPECT_EQ(read_file(ScratchFolder() / "absent").error().exit_code(), 2);
}

std::string read_or_refusal(const fs::path& path, std::size_t most = kMostTableBytes) {
  const auto begun = std::chrono::steady_clock::now();
  const auto content = read_file(path, most);
  EXPECT_LT(std::chrono::steady_clock::now() - begun, std::chrono::seconds(5)) << path;
  return content ? "read" : content.error().message;
}

// A pipe keeps its reader waiting for ever, a device may have no end.
TEST(File, OnlyPlainFilesAreRead) {
  const ScratchFolder scratch;
  const auto pipe = scratch / "pipe", link = scratch / "link", circle = scratch / "circle";
  ASSERT_EQ(::mkfifo(pipe.c_str(), 0600), 0);
  fs::create_symlink("/dev/zero", link);
  fs::create_symlink(circle, circle);
  EXPECT_NE(read_or_refusal(pipe).find("is a pipe"), std::string::npos) << read_or_refusal(pipe);
  EXPECT_NE(read_or_refusal(link).find("is a device"), std::string::npos) << read_or_refusal(link);
  EXPECT_NE(read_or_refusal("/dev/urandom").find("is a device"), std::string::npos);
  EXPECT_NE(read_or_refusal(scratch / ".").find("is a folder"), std::string::npos);
  EXPECT_NE(read_or_refusal(circle).find("symbolic links"), std::string::npos) << read_or_refusal(circle);
  EXPECT_NE(read_or_refusal(pipe / "below").find("no such file"), std::string::npos)
      << read_or_refusal(pipe / "below");
  EXPECT_FALSE(is_there(circle));
}

TEST(File, StandardInputIsNotRead) {
  EXPECT_EQ(read_or_refusal("-"), "-: standard input is not read; name a file");
}

TEST(File, TheSizeIsLookedAtBeforeAnythingIsRead) {
  const ScratchFolder scratch;
  const auto path = scratch / "sparse";
  ASSERT_TRUE(write_file(path, "").has_value());
  EXPECT_EQ(read_or_refusal(path), "read");
  fs::resize_file(path, std::uintmax_t{1} << 40);
  EXPECT_NE(read_or_refusal(path, kMostMeshBytes).find("holds 1099511627776 bytes; at most 1000000000"),
            std::string::npos)
      << read_or_refusal(path);
  fs::resize_file(path, 4097);
  EXPECT_NE(read_or_refusal(path, 4096).find("at most 4096"), std::string::npos);
  EXPECT_EQ(read_or_refusal(path, 4097), "read");
}

TEST(File, OfUnknownSizeIsReadToItsEnd) { EXPECT_NE(read_file("/proc/self/maps").value(), ""); }

// One that is still being recorded: half a row at its end would be the least that is wrong.
TEST(File, OneThatGrowsWhileItIsReadIsRefused) {
  const ScratchFolder scratch;
  const auto path = scratch / "growing";
  ASSERT_TRUE(write_file(path, std::string(50'000'000, 'a')).has_value());
  std::atomic<bool> stop = false;
  std::thread writer([&] {
    std::ofstream out(path, std::ios::app);
    while (!stop) out << "more\n" << std::flush;
  });
  bool refused = false;
  for (int i = 0; i < 1000 && !refused; ++i) {
    const auto content = read_file(path);
    refused = !content && content.error().message.find("changed while it was read") != std::string::npos;
    EXPECT_TRUE(content || refused) << content.error().message;
  }
  stop = true;
  writer.join();
  EXPECT_TRUE(refused);
}

std::size_t entries_of(const fs::path& folder) {
  return static_cast<std::size_t>(std::distance(fs::directory_iterator(folder), {}));
}

// The file that may not grow further ends the writer in the middle of its work.
void end_while_writing(const fs::path& path) {
  const pid_t child = ::fork();
  ASSERT_GE(child, 0);
  if (child == 0) {
    const rlimit small{4096, 4096}, no_core{0, 0};
    ::setrlimit(RLIMIT_CORE, &no_core);
    ::setrlimit(RLIMIT_FSIZE, &small);
    static_cast<void>(write_file(path, std::string(100'000, 'a')));
    ::_exit(0);
  }
  int status = 0;
  ASSERT_EQ(::waitpid(child, &status, 0), child);
  ASSERT_TRUE(WIFSIGNALED(status)) << status;
}

TEST(File, WhatAKilledWriterLeavesGoesWithTheNextWriting) {
  const ScratchFolder scratch;
  const auto path = scratch / "a.json";
  for (int i = 0; i < 3; ++i) ASSERT_NO_FATAL_FAILURE(end_while_writing(path));
  EXPECT_FALSE(fs::exists(path));
  EXPECT_EQ(entries_of(path.parent_path()), 1u) << "each took away what the one before had left";
  ASSERT_TRUE(write_file(path, "new").has_value());
  EXPECT_EQ(entries_of(path.parent_path()), 1u);
  EXPECT_EQ(*read_file(path), "new");
}

TEST(File, TwoWritersAtOnceLeaveEachOtherAlone) {
  const ScratchFolder scratch;
  const auto path = scratch / "a.csv";
  {
    auto first = CsvFile::begin(path, {"a"}), second = CsvFile::begin(path, {"b"});
    ASSERT_TRUE(first.has_value() && second.has_value());
    ASSERT_TRUE(write_file(path, "third").has_value());
    EXPECT_EQ(entries_of(path.parent_path()), 3u);
    ASSERT_TRUE(second->finish().has_value());
    EXPECT_EQ(*read_file(path), "b\n");
    ASSERT_TRUE(first->finish().has_value());
    EXPECT_EQ(*read_file(path), "a\n");
  }
  EXPECT_EQ(entries_of(path.parent_path()), 1u);
}

// As many as like: beyond the places that are looked at, a name is drawn by lot.
TEST(File, ManyWritersAtOnceAllComeToAnEnd) {
  const ScratchFolder scratch;
  const auto path = scratch / "a.csv";
  std::vector<std::thread> writers;
  std::atomic<int> failed = 0;
  for (int i = 0; i < 12; ++i)
    writers.emplace_back([&path, &failed] {
      for (int turn = 0; turn < 20; ++turn) failed += !write_file(path, std::string(1000, 'a')).has_value();
    });
  for (auto& writer : writers) writer.join();
  EXPECT_EQ(failed, 0);
  EXPECT_EQ(entries_of(path.parent_path()), 1u);
  EXPECT_EQ(read_file(path)->size(), 1000u);
}

// What others have put in its place stays: links, folders, pipes, another's file.
TEST(File, OnlyFilesOfOursAreTakenForLeftBehind) {
  const ScratchFolder scratch;
  const auto path = scratch / "a.json", other = scratch / "other";
  ASSERT_TRUE(write_file(other, "kept").has_value());
  for (int i = 1; i <= 8; ++i) {
    const fs::path place = path.string() + ".part-" + std::to_string(i);
    if (i < 8)
      fs::create_symlink(other, place);
    else
      ASSERT_EQ(::mkfifo(place.c_str(), 0600), 0);
  }
  ASSERT_TRUE(write_file(path, "new").has_value());
  EXPECT_EQ(*read_file(other), "kept");
  EXPECT_EQ(entries_of(path.parent_path()), 10u);
}

TEST(Json, LabelsThatAreNoUtf8DoNotStopAResult) {
  const ScratchFolder scratch;
  ASSERT_TRUE(write_json(scratch / "result.json", Json{{"label", "M\xFCller"}}).has_value());
  EXPECT_EQ(*read_file(scratch / "result.json"), "{\n  \"label\": \"M\xEF\xBF\xBDller\"\n}\n");
}

TEST(Json, NamesSteerNoTerminalOnStandardOutput) {
  const ScratchFolder scratch;
  const Json named{{"name", "\u202Eexe.\u009B31m\x1B[31m"}};
  ASSERT_TRUE(write_json(scratch / "result.json", named).has_value());
  const auto written = *read_file(scratch / "result.json");
  EXPECT_EQ(written, "{\n  \"name\": \"\\u202eexe.\\u009b31m\\u001b[31m\"\n}\n");
  EXPECT_EQ(Json::parse(written), named);
}

}  // namespace
}  // namespace palpate::inline core
