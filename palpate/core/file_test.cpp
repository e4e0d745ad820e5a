#include "palpate/core/file.h"

#include "tests/scratch_folder.h"

#include <gtest/gtest.h>

#include "palpate/core/json.h"

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

TEST(Json, LabelsThatAreNoUtf8DoNotStopAResult) {
  const ScratchFolder scratch;
  ASSERT_TRUE(write_json(scratch / "result.json", Json{{"label", "M\xFCller"}}).has_value());
  EXPECT_EQ(*read_file(scratch / "result.json"), "{\n  \"label\": \"M\xEF\xBF\xBDller\"\n}\n");
}

}  // namespace
}  // namespace palpate::inline core
