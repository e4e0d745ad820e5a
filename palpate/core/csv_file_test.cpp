#include "palpate/core/csv_file.h"

#include <gtest/gtest.h>
#include <sys/resource.h>

#include <csignal>

#include "palpate/core/file.h"
#include "tests/scratch_folder.h"

namespace palpate::inline core {
namespace {

std::size_t files_in(const std::filesystem::path& folder) {
  return static_cast<std::size_t>(std::distance(std::filesystem::directory_iterator(folder), {}));
}

TEST(CsvFile, IsThereWholeAfterItsEndAndNotBefore) {
  const ScratchFolder scratch;
  const auto path = scratch / "rows.csv";
  {
    auto table = CsvFile::begin(path, {"time_s", "answer"});
    ASSERT_TRUE(table.has_value());
    table->row(std::vector<double>{0.5, 2.0});
    table->row(std::vector<std::string>{"", "exact"});
    EXPECT_FALSE(std::filesystem::exists(path));
    ASSERT_TRUE(table->finish().has_value());
  }
  EXPECT_EQ(*read_file(path), "time_s,answer\n0.5,2\n,exact\n");
  EXPECT_EQ(files_in(path.parent_path()), 1u);
}

TEST(CsvFile, LeavesNothingBehindWhereItIsNotFinished) {
  const ScratchFolder scratch;
  const auto path = scratch / "rows.csv";
  ASSERT_TRUE(CsvFile::begin(path, {"a"}).has_value());
  EXPECT_EQ(files_in(path.parent_path()), 0u);
  EXPECT_EQ(CsvFile::begin(scratch / "no-folder" / "rows.csv", {"a"}).error().exit_code(), 2);
}

TEST(CsvFile, AFullDiskIsSaidAndTheOldFileStays) {
  const ScratchFolder scratch;
  const auto path = scratch / "rows.csv";
  ASSERT_TRUE(write_file(path, "old").has_value());
  rlimit before{};
  ASSERT_EQ(::getrlimit(RLIMIT_FSIZE, &before), 0);
  const auto handler = std::signal(SIGXFSZ, SIG_IGN);
  {
    auto table = CsvFile::begin(path, {"a"});
    ASSERT_TRUE(table.has_value());
    const rlimit small{4096, before.rlim_max};
    ASSERT_EQ(::setrlimit(RLIMIT_FSIZE, &small), 0);
    for (int i = 0; i < 10000; ++i) table->row(std::vector<double>{1.0});
    const auto finished = table->finish();
    ASSERT_EQ(::setrlimit(RLIMIT_FSIZE, &before), 0);
    ASSERT_FALSE(finished.has_value());
    EXPECT_NE(finished.error().message.find("free some space"), std::string::npos);
  }
  std::signal(SIGXFSZ, handler);
  EXPECT_EQ(*read_file(path), "old");
  EXPECT_EQ(files_in(path.parent_path()), 1u);
}

}  // namespace
}  // namespace palpate::inline core
