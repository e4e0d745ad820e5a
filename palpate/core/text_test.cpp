#include "palpate/core/text.h"

#include <gtest/gtest.h>

#include <vector>

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

std::string utf8(char32_t code) {
  const auto tail = [code](int shift) { return static_cast<char>(0x80 | ((code >> shift) & 0x3F)); };
  if (code < 0x80) return {static_cast<char>(code)};
  if (code < 0x800) return {static_cast<char>(0xC0 | code >> 6), tail(0)};
  if (code < 0x10000) return {static_cast<char>(0xE0 | code >> 12), tail(6), tail(0)};
  return {static_cast<char>(0xF0 | code >> 18), tail(12), tail(6), tail(0)};
}

// U+009B begins an escape sequence as ESC [ does; U+202E shows "exe.txt" as "txt.exe".
TEST(Excerpt, ShowsNothingThatSteersATerminalOrTurnsTheWriting) {
  std::vector<char32_t> codes{0x061C, 0x200B, 0x200E, 0x200F, 0xFEFF, 0xE0041};
  for (char32_t code = 0; code < 32; ++code) codes.push_back(code);
  for (char32_t code = 0x7F; code < 0xA0; ++code) codes.push_back(code);
  for (char32_t code = 0x2028; code <= 0x202E; ++code) codes.push_back(code);
  for (char32_t code = 0x2066; code <= 0x2069; ++code) codes.push_back(code);
  for (const char32_t code : codes) {
    EXPECT_EQ(excerpt("a" + utf8(code) + "b"), "a?b") << std::hex << static_cast<unsigned>(code);
    EXPECT_FALSE(is_plain("a" + utf8(code)));
    EXPECT_TRUE(has_control(utf8(code) + "a"));
  }
}

TEST(Excerpt, ShowsLettersOfAllScripts) {
  const std::string letters = "Gr\u00F6\u00DFe \u0645\u06CC\u200C\u062E \u6F22 \U0001F9E0 \u00A0\uFFFD";
  EXPECT_EQ(excerpt(letters, 80), letters);
  EXPECT_TRUE(is_plain(letters));
}

TEST(Excerpt, ShowsAMarkForEachByteThatIsNoUtf8) {
  EXPECT_EQ(excerpt("M\xFCller"), "M?ller");       // Latin-1
  EXPECT_EQ(excerpt("\xC0\x9B"), "??");            // ESC [ in a form that is too long
  EXPECT_EQ(excerpt("\xED\xA0\x80"), "???");       // half of a pair
  EXPECT_EQ(excerpt("\xF4\x90\x80\x80"), "????");  // beyond the last character
  EXPECT_EQ(excerpt("a\xE2\x80"), "a??");          // cut off by whoever wrote it
  EXPECT_EQ(excerpt(std::string(100, '\x80'), 10).size(),
            7u + 3u);  // a run of them has no beginning to cut at
  EXPECT_FALSE(is_plain("M\xFCller"));
  EXPECT_FALSE(has_control("M\xFCller"));
}

TEST(OneLine, CutsNothing) {
  EXPECT_EQ(one_line(std::string(5000, 'a') + "\n"), std::string(5000, 'a') + "?");
}

TEST(EscapedJson, SaysTheSameInCharactersThatATerminalMayShow) {
  EXPECT_EQ(escaped_json("{\n  \"a\": \"\u00E4\u202E\u009B\U000E0041\"\n}\n"),
            "{\n  \"a\": \"\u00E4\\u202e\\u009b\\udb40\\udc41\"\n}\n");
}

TEST(Counted, SaysOneOrMany) {
  EXPECT_EQ(counted(1, "pose"), "1 pose");
  EXPECT_EQ(counted(0, "pose"), "0 poses");
  EXPECT_EQ(counted(12, "view"), "12 views");
}

}  // namespace
}  // namespace palpate::inline core
