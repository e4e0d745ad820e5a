#include "palpate/core/run_directory.h"

#include "tests/scratch_folder.h"

#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cstdlib>

namespace palpate::inline core {
namespace {

class RunDirectory : public testing::Test {
 protected:
  ScratchFolder scratch_;
  const std::filesystem::path base_ = scratch_.path();
};

TEST_F(RunDirectory, IsMadeForThisUserAlone) {
  const auto folder = private_directory(base_ / "mine");
  ASSERT_TRUE(folder.has_value()) << folder.error().message;
  struct stat info {};
  ASSERT_EQ(stat(folder->c_str(), &info), 0);
  EXPECT_EQ(info.st_mode & 0777, 0700u);
  EXPECT_TRUE(private_directory(base_ / "mine").has_value());  // and found again
}

TEST_F(RunDirectory, RefusesWhatOthersCouldReachOrPlant) {
  ASSERT_EQ(mkdir((base_ / "open").c_str(), 0700), 0);
  ASSERT_EQ(chmod((base_ / "open").c_str(), 0755), 0);
  EXPECT_FALSE(private_directory(base_ / "open").has_value());
  std::filesystem::create_directory_symlink(base_, base_ / "link");
  EXPECT_FALSE(private_directory(base_ / "link").has_value());
  EXPECT_FALSE(private_directory(base_ / "missing" / "deep").has_value());
}

TEST_F(RunDirectory, FollowsTheRuntimeFolderOfTheLogin) {
  const char* old = std::getenv("XDG_RUNTIME_DIR");
  const std::string kept = old != nullptr ? old : "";
  setenv("XDG_RUNTIME_DIR", base_.c_str(), 1);
  const auto folder = run_directory();
  old != nullptr ? setenv("XDG_RUNTIME_DIR", kept.c_str(), 1) : unsetenv("XDG_RUNTIME_DIR");
  ASSERT_TRUE(folder.has_value()) << folder.error().message;
  EXPECT_EQ(*folder, base_ / "palpate");
}

TEST_F(RunDirectory, WithoutARuntimeFolderTheUsersNumberNamesOneInSharedMemory) {
  const char* old = std::getenv("XDG_RUNTIME_DIR");
  const std::string kept = old != nullptr ? old : "";
  for (const std::string& value : {std::string("not/absolute"), (base_ / "missing").string()}) {
    setenv("XDG_RUNTIME_DIR", value.c_str(), 1);
    const auto folder = run_directory();
    ASSERT_TRUE(folder.has_value()) << folder.error().message;
    EXPECT_EQ(*folder, fmt::format("/dev/shm/palpate-{}", geteuid()));
  }
  old != nullptr ? setenv("XDG_RUNTIME_DIR", kept.c_str(), 1) : unsetenv("XDG_RUNTIME_DIR");
}

}  // namespace
}  // namespace palpate::inline core
