#include "palpate/core/toml.h"

#include <gtest/gtest.h>

#include <chrono>

namespace palpate::inline core {
namespace {

TomlTable parsed(std::string_view content) {
  auto table = parse_toml(content, "file.toml");
  EXPECT_TRUE(table.has_value());
  return *table;
}

std::string complaint(const TomlTable& table) {
  const auto done = table.finish();
  return done ? "none" : done.error().message;
}

TEST(Toml, ReadsEveryKindOfValue) {
  const auto file = parsed(
      "name = 'a'\nrate_hz = 100\non = true\nlist = [1, 2.5, 3]\nrows = [[1, 2], [3, 4]]\n"
      "[sub]\nx = 1.5\n[[joint]]\na = 1\n[[joint]]\na = 2\n");
  EXPECT_EQ(file.text("name"), "a");
  EXPECT_EQ(file.number("rate_hz"), 100.0);
  EXPECT_TRUE(file.flag("on"));
  EXPECT_EQ((file.numbers<3>("list")), (std::array<double, 3>{1.0, 2.5, 3.0}));
  EXPECT_EQ(file.rows("rows", 2)[1][0], 3.0);
  EXPECT_EQ(file.table("sub").number("x"), 1.5);
  const auto joints = file.tables("joint");
  ASSERT_EQ(joints.size(), 2u);
  EXPECT_EQ(joints[0].integer("a") + joints[1].integer("a"), 3);
  EXPECT_EQ(file.number_or("absent", 7.0), 7.0);
  EXPECT_FALSE(file.table("nothing").exists());
  EXPECT_EQ(complaint(file), "none");
}

TEST(Toml, UnknownKeysAreNamedWithFileAndLine) {
  const auto file = parsed("[arm]\ngain_sd = 0.1\ngain_sdd = 0.2\n");
  file.table("arm").number("gain_sd");
  EXPECT_EQ(complaint(file), "file.toml:3: unknown key 'arm.gain_sdd'; did you mean 'gain_sd'?");
}

TEST(Toml, UnknownTablesAreNamed) {
  const auto file = parsed("x = 1\n[[thing]]\ny = 1\n");
  file.number("x");
  EXPECT_NE(complaint(file).find("file.toml:2: unknown key 'thing'"), std::string::npos) << complaint(file);
}

TEST(Toml, UnknownKeysInsideListsOfTablesAreFound) {
  const auto file = parsed("[[joint]]\na = 1\n[[joint]]\na = 2\nbb = 3\n");
  for (const auto& joint : file.tables("joint")) joint.number("a");
  EXPECT_NE(complaint(file).find("file.toml:5: unknown key 'joint[2].bb'"), std::string::npos)
      << complaint(file);
}

TEST(Toml, WrongTypesRangesAndMissingKeysAreNamed) {
  const auto check = [](std::string_view content, auto read, std::string_view expected) {
    const auto file = parsed(content);
    read(file);
    EXPECT_NE(complaint(file).find(expected), std::string::npos) << complaint(file);
    EXPECT_EQ(file.finish().error().kind, Error::Kind::wrong_use);
  };
  check(
      "a = 'x'", [](auto& f) { f.number("a"); }, "file.toml:1: a: is a text, a number is expected");
  check(
      "\na = -1", [](auto& f) { f.number("a", kPositive); }, "file.toml:2: a: is -1, a number above 0");
  check(
      "a = nan", [](auto& f) { f.number("a"); }, "finite");
  check(
      "a = 3", [](auto& f) { f.number("a", {.low = 0, .high = 2}); }, "0 to 2 is expected");
  check(
      "", [](auto& f) { f.number("a"); }, "a: is missing");
  check(
      "a = [1, 2]", [](auto& f) { f.numbers("a", 3); }, "has 2 entries, a list of 3 numbers");
  check(
      "a = [[1, 2], [3]]", [](auto& f) { f.rows("a", 2); }, "entry 2 is not a list of 2 numbers");
  check(
      "a = 1.5", [](auto& f) { f.integer("a"); }, "a whole number is expected");
  check(
      "a = 'z'",
      [](auto& f) {
        f.choice("a", {"x", "y"});
      },
      "one of \"x\", \"y\" is expected");
  check(
      "a = 1", [](auto& f) { f.table("a"); }, "a table is expected");
  check(
      "", [](auto& f) { f.table("a").number("b"); }, "a.b: is missing");
}

TEST(Toml, AMissingKeyIsLookedForAmongUnknownOnes) {
  const auto misspelt = parsed("[arm]\nlength_mm = [1, 2]\nfx = 1\n");
  misspelt.table("arm").numbers("lengths_mm", 2);
  misspelt.table("arm").number("fx");
  EXPECT_EQ(
      complaint(misspelt),
      "file.toml:1: arm.lengths_mm: is missing, a list of 2 numbers is expected; 'length_mm' is an unknown "
      "key, was it meant?");
  // A key that is known is not taken for one that is not there.
  const auto missing = parsed("fx = 1\n");
  missing.number("fy");
  missing.number("fx");
  EXPECT_EQ(complaint(missing), "file.toml:1: fy: is missing, a number is expected");
}

TEST(Toml, OnlyTheFirstComplaintIsReported) {
  const auto file = parsed("a = 'x'\nb = 'y'\n");
  file.number("b");
  file.number("a");
  EXPECT_NE(complaint(file).find("file.toml:2: b"), std::string::npos);
}

TEST(Toml, BrokenSyntaxIsOneLineWithItsPlace) {
  const auto broken = parse_toml("a = 1\nb = = 2\n", "file.toml");
  ASSERT_FALSE(broken.has_value());
  EXPECT_EQ(broken.error().message.find("file.toml:2: is not valid TOML"), 0u) << broken.error().message;
  EXPECT_EQ(broken.error().message.find('\n'), std::string::npos);
}

std::string refusal(const std::string& content) {
  const auto table = parse_toml(content, "file.toml");
  return table ? "none" : table.error().message;
}

std::string repeated(const std::string& text, int times) {
  std::string all;
  for (int i = 0; i < times; ++i) all += text;
  return all;
}

// Given to the library, each of these ended the process.
TEST(Toml, RefusesKeysThatAreTooDeepBeforeTheyAreTables) {
  const std::string deep = repeated("a.", 60000) + "a";
  const std::string apart = repeated("a . ", 60000) + "a", quoted = repeated("\"a.b\".'c'.", 60000) + "a";
  for (const auto& content :
       {"[" + deep + "]", "[[" + deep + "]]", deep + " = 1", "x = {" + deep + " = 1}",
        "x = [{" + deep + " = 1}]", "\n[" + apart + "]", "[" + quoted + "]", "# '''\n" + deep + " = 1",
        "a = \"\"\"\"b\"\"\"\"\"\n" + deep + " = 1", "a = 'b\\'\n" + deep + " = 1"})
    EXPECT_NE(refusal(content + "\n").find("has a key of more than 33 parts"), std::string::npos)
        << refusal(content).substr(0, 200) << " of " << content.substr(0, 60);
  EXPECT_EQ(refusal("a = 1\n\n[" + deep + "]").substr(0, 12), "file.toml:3:");
}

TEST(Toml, RefusesBracketsThatAreTooDeep) {
  for (const std::string open : {"[", "{a = ", "[{a.b.c.d = ["})
    EXPECT_NE(refusal("x = " + repeated(open, 1000)).find("brackets in each other"), std::string::npos)
        << open;
}

// A thousand tables in each other are no trouble, for the library nor for a small stack.
TEST(Toml, WhatIsJustShallowEnoughIsTakenDownAgain) {
  const std::string deep = repeated("a.", 32) + "a";
  EXPECT_EQ(refusal("[" + deep + "]\n" + deep + " = " + repeated("{" + deep + " = ", 31) + "{" +
                    repeated("}", 32) + "\n"),
            "none");
}

// The library looks through all tables for each further one: these took it many seconds.
TEST(Toml, RefusesMoreTablesThanItsLibraryFindsAgainInTime) {
  std::string headers, dotted;
  for (int i = 0; i < 100000; ++i) {
    headers += fmt::format("[[a{}]]\n[[a{}]]\n", i, i);
    dotted += fmt::format("a{}.b = 1\na{}.c = 1\n", i, i);
  }
  EXPECT_NE(refusal(headers).find("tables"), std::string::npos);
  EXPECT_NE(refusal(dotted).find("tables"), std::string::npos);
}

TEST(Toml, RefusesWhatIsNoTextAndWhatIsTooLarge) {
  EXPECT_NE(refusal(std::string("a = 1\n\0", 7)).find("file.toml:2: holds a zero byte"), std::string::npos);
  EXPECT_NE(refusal("a = '" + std::string(4'000'000, 'x') + "'").find("at most 4000000"), std::string::npos);
  EXPECT_NE(refusal("a = 1\rb = 2\r" + repeated("a.", 60000) + "a = 1\r"), "none");
}

TEST(Toml, DotsInNumbersTextsAndCommentsAreNoKeys) {
  const std::string dots(100, '.'), many = repeated("1.5, ", 1000);
  for (const auto& content :
       {"a = [" + many + "]", "a = [[" + many + "], [" + many + "]]", "a = '" + dots + "'",
        "a = \"" + dots + "\"", "a = 1 # " + dots, "a = \"\"\"\n" + dots + "\n\\\"" + dots + "\"\"\"",
        "a = '''" + dots + "\n" + dots + "'''", "a = \"\\\"" + dots + "\"", "'" + dots + "' = 1",
        "a = \"\"\"" + dots + "\"\"\"\"\"\nb = 1", repeated("a.", 32) + "a = 1.5",
        "x = \"\"\ny = '" + dots + "'"})
    EXPECT_EQ(refusal(content + "\n"), "none") << content.substr(0, 80);
}

// A key that nobody knows is compared with those that are known, letter by letter: a minute for these.
TEST(Toml, AKeyAsLongAsAFileIsNamedAtOnce) {
  const auto file = parsed(std::string(3'900'000, 'k') + " = 1\n");
  for (int i = 0; i < 400; ++i) file.number_or(fmt::format("one_of_many_keys_{}", i), 1.0);
  const auto begun = std::chrono::steady_clock::now();
  EXPECT_EQ(complaint(file).substr(0, 36), "file.toml:1: unknown key 'kkkkkkkkkk");
  EXPECT_LT(std::chrono::steady_clock::now() - begun, std::chrono::seconds(20));
}

TEST(Toml, TextsAreWrittenSoThatTheyCanBeReadAndShown) {
  EXPECT_EQ(toml_quoted("a\u202Eb\u009Bc\U000E0041"), "\"a\\u202eb\\u009bc\\U000e0041\"");
  EXPECT_EQ(parsed("a = " + toml_quoted("a\u202Eb")).text("a"), "a\u202Eb");
  EXPECT_EQ(parsed("a = " + toml_quoted("M\xFCller")).text("a"), "M\uFFFDller");  // Latin-1, from a table
}

TEST(Toml, NumbersAndTextsSurviveWritingAndReading) {
  for (double value : {0.1, 1.0, -1e-17, 123456789.123456789, 2e300}) {
    const auto file = parsed("a = " + toml_number(value));
    EXPECT_EQ(file.number("a"), value);
  }
  EXPECT_EQ(parsed("a = " + toml_quoted("x\"\\\ty")).text("a"), "x\"\\\ty");
}

}  // namespace
}  // namespace palpate::inline core
