#include "palpate/core/file.h"

#include <gtest/gtest.h>
#include <unistd.h>

namespace palpate {
namespace {

namespace fs = std::filesystem;

fs::path scratch(const std::string& name) {
  return fs::temp_directory_path() / fmt::format("palpate-{}-{}", ::getpid(), name);
}

TEST(File, ComesBackAsWritten) {
  const auto path = scratch("whole");
  ASSERT_TRUE(write_file(path, "first").has_value());
  ASSERT_TRUE(write_file(path, "second").has_value());
  EXPECT_EQ(read_file(path).value(), "second");
  fs::remove(path);
}

TEST(File, AFullDiskIsSaidAndNothingIsLeft) {
  if (!fs::exists("/dev/full")) GTEST_FAIL() << "this test needs /dev/full";
  const auto written = write_file("/dev/full", "text");
  ASSERT_FALSE(written.has_value());
  EXPECT_NE(written.error().message.find("No space left"), std::string::npos);
}

TEST(File, AMissingFolderIsWrongUse) {
  const auto written = write_file(scratch("no-folder") / "a.json", "text");
  ASSERT_FALSE(written.has_value());
  EXPECT_EQ(written.error().exit_code(), 2);
}

TEST(File, AMissingFileIsWrongUse) { EXPECT_EQ(read_file(scratch("absent")).error().exit_code(), 2); }

}  // namespace
}  // namespace palpate
