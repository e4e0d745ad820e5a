#include "palpate/core/file_lock.h"

#include <gtest/gtest.h>

#include <atomic>
#include <thread>
#include <vector>

#include "tests/scratch_folder.h"

namespace palpate::inline core {
namespace {

class FileLock : public testing::Test {
 protected:
  ScratchFolder folder_;
  std::filesystem::path path_ = folder_ / "a.lock";
};

TEST_F(FileLock, IsHeldByOneAndFreeWithItsEnd) {
  auto held = lock_file(path_);
  ASSERT_TRUE(held && *held);
  const auto other = lock_file(path_);
  ASSERT_TRUE(other);
  EXPECT_FALSE(*other);
  (*held)->close();
  const auto again = lock_file(path_);
  EXPECT_TRUE(again && *again);
}

TEST_F(FileLock, AFileThatWasRemovedIsNotLocked) {
  auto held = lock_file(path_);
  ASSERT_TRUE(held && *held);
  std::filesystem::remove(path_);
  EXPECT_FALSE(is_at(path_, (*held)->get()));
  const auto next = lock_file(path_);  // a new file of that name
  ASSERT_TRUE(next && *next);
  EXPECT_TRUE(is_at(path_, (*next)->get()));
}

// Whoever locks sees that nobody else does, though each removes the file before it lets go.
TEST_F(FileLock, HoldersThatRemoveItNeverMeet) {
  std::atomic<int> inside{0}, locked{0};
  std::atomic<bool> met{false};
  std::vector<std::thread> threads;
  for (int t = 0; t < 4; ++t)
    threads.emplace_back([&] {
      for (int i = 0; i < 2000; ++i) {
        auto lock = lock_file(path_);
        if (!lock || !*lock) continue;
        if (++inside != 1) met = true;
        ++locked;
        --inside;
        std::filesystem::remove(path_);
        (*lock)->close();
      }
    });
  for (auto& thread : threads) thread.join();
  EXPECT_FALSE(met);
  EXPECT_GT(locked, 100);
}

TEST_F(FileLock, AFolderThatIsNotThereAndALinkAreRefused) {
  const auto nowhere = lock_file(folder_ / "nowhere" / "a.lock");
  ASSERT_FALSE(nowhere);
  EXPECT_NE(nowhere.error().message.find("cannot be opened"), std::string::npos);
  std::filesystem::create_symlink(folder_ / "elsewhere", path_);
  EXPECT_FALSE(lock_file(path_));
  EXPECT_FALSE(std::filesystem::exists(folder_ / "elsewhere"));
}

}  // namespace
}  // namespace palpate::inline core
