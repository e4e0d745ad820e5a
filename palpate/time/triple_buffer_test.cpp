#include "palpate/time/triple_buffer.h"

#include <gtest/gtest.h>

#include <cstdint>
#include <thread>

namespace palpate::inline time {
namespace {

TEST(TripleBuffer, KeepsTheNewestAndGivesItOnce) {
  TripleBuffer<int> box;
  int value = -1;
  EXPECT_FALSE(box.read(value));
  EXPECT_EQ(value, -1);
  box.write(1);
  box.write(2);
  EXPECT_TRUE(box.read(value));
  EXPECT_EQ(value, 2);
  EXPECT_FALSE(box.read(value));
  box.write(3);
  EXPECT_TRUE(box.read(value));
  EXPECT_EQ(value, 3);
}

// A torn value would have unequal words; a stale one would go back in time. The thread sanitizer watches as
// well.
TEST(TripleBuffer, NeverTearsAndNeverGoesBack) {
  using Words = std::array<std::uint64_t, 32>;
  TripleBuffer<Words> box;
  constexpr std::uint64_t kLast = 100000;
  std::jthread writer([&] {
    Words words;
    for (std::uint64_t i = 1; i <= kLast; ++i) {
      words.fill(i);
      box.write(words);
    }
  });
  std::uint64_t last = 0;
  Words words{};
  while (last < kLast) {
    if (!box.read(words)) continue;
    for (const auto word : words) ASSERT_EQ(word, words[0]);
    ASSERT_GT(words[0], last);
    last = words[0];
  }
}

}  // namespace
}  // namespace palpate::inline time
