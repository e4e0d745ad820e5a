#include "palpate/time/freed_memory.h"

#include <gtest/gtest.h>
#include <sys/mman.h>

#include <cstring>
#include <memory>
#include <utility>
#include <vector>

#include "palpate/time/real_time.h"
#include "tests/sanitized.h"

namespace palpate::inline time {
namespace {

constexpr std::size_t kMib = 1 << 20;

TEST(FreedMemory, GrowsWithTheProcessOrWithWhatIsFree) {
  FreedMemory memory(16 * kMib, 20 * kMib, 0);
  EXPECT_FALSE(memory.has_grown(280 * kMib, 0));  // in use
  EXPECT_FALSE(memory.has_grown(280 * kMib, 15 * kMib));
  EXPECT_TRUE(memory.has_grown(280 * kMib, 16 * kMib));
  // Half of it was free when it was given back: the other half makes no process grow.
  memory.was_given_back(150 * kMib, 130 * kMib);
  EXPECT_FALSE(memory.has_grown(150 * kMib, 145 * kMib));
  EXPECT_TRUE(memory.has_grown(150 * kMib, 260 * kMib));
  memory.was_given_back(20 * kMib, 260 * kMib);  // free, and not there
  EXPECT_FALSE(memory.has_grown(20 * kMib, 260 * kMib));
  EXPECT_TRUE(memory.has_grown(36 * kMib, 260 * kMib));
  // What is in use again, and then free again.
  EXPECT_FALSE(memory.has_grown(35 * kMib, 100 * kMib));
  EXPECT_TRUE(memory.has_grown(35 * kMib, 116 * kMib));
}

#ifndef PALPATE_SANITIZED  // a sanitizer has a malloc of its own
// Many messages, of which the last one stays: what lies before it does not go back by itself.
std::unique_ptr<char[]> burst() {
  std::vector<std::unique_ptr<char[]>> messages;
  for (int i = 0; i < 2000; ++i) {
    messages.push_back(std::make_unique<char[]>(60'000));
    std::memset(messages.back().get(), 1, 60'000);
  }
  return std::move(messages.back());
}

TEST(FreedMemory, GoesBackWhereItIsKeptAndWhereItIsLocked) {
  keep_freed_memory();
  for (const bool lock : {false, true}) {
    // Without the right to lock there is nothing to be shown.
    if (lock && mlockall(MCL_CURRENT | MCL_FUTURE | MCL_ONFAULT) != 0) break;
    const std::size_t before = resident_bytes();
    const auto stays = burst();
    EXPECT_GT(resident_bytes(), before + (60 << 20)) << lock;
    give_back_freed_memory();
    EXPECT_LT(resident_bytes(), before + (16 << 20)) << lock;
  }
  munlockall();
}
#endif

}  // namespace
}  // namespace palpate::inline time
