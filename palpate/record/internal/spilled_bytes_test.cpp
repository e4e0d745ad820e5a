#include "palpate/record/internal/spilled_bytes.h"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <cerrno>

#include "palpate/record/recording_for_tests.h"

namespace palpate::record {
namespace {

constexpr std::size_t kInMemory = SpilledBytes::kInMemory;

std::string piece(std::size_t size, char of) { return std::string(size, of); }

std::string all_of(const SpilledBytes& bytes) {
  std::string all, part;
  for (std::uint64_t at = 0; at < bytes.size(); at += part.size()) {
    EXPECT_EQ(bytes.read(at, part), 0);
    if (part.empty()) break;
    all += part;
  }
  return all;
}

TEST(SpilledBytes, AreReadAsTheyCameAndMemoryKeepsFew) {
  const ScratchFolder folder;
  SpilledBytes in_file(nameless_file(folder / "s.mcap")), in_memory;
  std::string expected;
  for (std::size_t i = 0; i < 3000; ++i) {
    const auto bytes = piece(i == 1000 ? 3 * kInMemory : i * 7 % 400, static_cast<char>(i));
    ASSERT_EQ(in_file.append(bytes), 0);
    ASSERT_EQ(in_memory.append(bytes), 0);
    expected += bytes;
    ASSERT_EQ(in_file.size(), expected.size());
    ASSERT_LE(in_file.in_memory(), std::max(kInMemory, bytes.size()));
  }
  EXPECT_EQ(all_of(in_file), expected);
  EXPECT_EQ(all_of(in_memory), expected);
  EXPECT_EQ(in_memory.in_memory(), expected.size()) << "without a file";
}

TEST(SpilledBytes, AWriteThatFailsLosesNothingAndMayBeTriedAgain) {
  const ScratchFolder folder;
  SpilledBytes bytes(nameless_file(folder / "s.mcap"));
  std::string expected;
  const auto add = [&](char of) {
    const int error = bytes.append(piece(1000, of));
    if (error == 0) expected += piece(1000, of);
    return error;
  };
  {
    const FileLimit limit(kInMemory * 3 / 2);  // the second time it writes a half
    int error = 0;
    for (char of = 'a'; error == 0 && expected.size() < 10 * kInMemory; ++of) error = add(of);
    EXPECT_EQ(error, EFBIG);
  }
  EXPECT_GT(expected.size(), kInMemory);
  EXPECT_EQ(bytes.size(), expected.size());
  EXPECT_EQ(all_of(bytes), expected);
  for (int i = 0; i < 200; ++i) EXPECT_EQ(add('z'), 0);
  EXPECT_EQ(all_of(bytes), expected);
}

TEST(SpilledBytes, WhatTheDiskHasLostIsNoEnd) {
  const ScratchFolder folder;
  FileDescriptor file = nameless_file(folder / "s.mcap");
  const FileDescriptor same(::fcntl(file.get(), F_DUPFD_CLOEXEC, 0));
  SpilledBytes bytes(std::move(file));
  EXPECT_EQ(bytes.append(piece(kInMemory, 'a')), 0);
  EXPECT_EQ(bytes.append("b"), 0);
  ASSERT_EQ(::ftruncate(same.get(), 0), 0);
  std::string part;
  EXPECT_EQ(bytes.read(0, part), EIO);
  EXPECT_EQ(bytes.read(kInMemory, part), 0);
  EXPECT_EQ(part, "b");
}

TEST(SpilledBytes, TheirFileHasNoNameByEitherWay) {
  const ScratchFolder folder;
  for (const auto& make : {nameless_file, unlinked_file}) {
    SpilledBytes bytes(make(folder / "s.mcap"));
    for (int i = 0; i < 100; ++i) ASSERT_EQ(bytes.append(piece(1000, 'x')), 0);
    EXPECT_LT(bytes.in_memory(), 100'000u) << "there is a file";
    EXPECT_EQ(all_of(bytes), piece(100'000, 'x'));
    EXPECT_EQ(files_in(folder.path()), 0);
    EXPECT_FALSE(make(folder / "nowhere" / "s.mcap"));
  }
}

}  // namespace
}  // namespace palpate::record
