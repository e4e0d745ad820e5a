#include "palpate/core/text.h"

#include <gtest/gtest.h>

namespace palpate::inline core {
namespace {

TEST(Excerpt, ShowsShortTextAsItIs) {
  EXPECT_EQ(excerpt("x_mm"), "x_mm");
  EXPECT_EQ(excerpt(""), "");
}

TEST(Excerpt, CutsLongTextBetweenCharacters) {
  EXPECT_EQ(excerpt("abcdef", 3), "abc...");
  EXPECT_EQ(excerpt("ab\xC3\xA4", 3), "ab...");  // the character of two bytes would be cut in half
  EXPECT_EQ(excerpt("abc", 3), "abc");
}

TEST(Excerpt, IsOneLineWithoutControlCharacters) { EXPECT_EQ(excerpt("a\nb\r\x1b[31m\x7f"), "a?b??[31m?"); }

TEST(Counted, SaysOneOrMany) {
  EXPECT_EQ(counted(1, "pose"), "1 pose");
  EXPECT_EQ(counted(0, "pose"), "0 poses");
  EXPECT_EQ(counted(12, "view"), "12 views");
}

}  // namespace
}  // namespace palpate::inline core
