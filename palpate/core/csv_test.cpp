#include "palpate/core/csv.h"

#include <gtest/gtest.h>

#include <cmath>

namespace palpate::inline core {
namespace {

TEST(Csv, ReadsHeaderCommentsAndNumbers) {
  const auto table = parse_csv("# comment\nt_s,x_mm\n0,1.5\n\n1,-2e3\r\n", "a.csv");
  ASSERT_TRUE(table.has_value());
  ASSERT_EQ(table->rows.size(), 2u);
  EXPECT_EQ(table->rows[1][1], -2000.0);
  EXPECT_EQ(table->line[1], 5);
}

TEST(Csv, NamesFileLineAndColumnOfAnOddCell) {
  const auto table = parse_csv("t_s,x_mm\n0,1\n1,abc\n", "a.csv");
  ASSERT_TRUE(table.has_value());
  const auto asked = table->require("x_mm");
  ASSERT_FALSE(asked.has_value());
  EXPECT_EQ(asked.error().message, "a.csv:3: x_mm is 'abc', a number is expected");
  EXPECT_EQ(asked.error().exit_code(), 2);
}

// "More columns are welcome": the name of a frame, a tracker's state, a number that was not there.
TEST(Csv, AColumnNobodyAsksForMayHoldAnything) {
  const auto table = parse_csv("t_s,frame_id,q,x_mm\n0,world,,1\n1,\"map\",nan,2\n2,7,-inf,3\n", "a.csv");
  ASSERT_TRUE(table.has_value());
  EXPECT_EQ(table->require("x_mm"), 3u);
  EXPECT_EQ(table->require("t_s"), 0u);
  EXPECT_EQ(table->text[0][1], "world");
  EXPECT_TRUE(std::isnan(table->rows[2][2]));  // where somebody reads it nevertheless it is no number
  EXPECT_EQ(table->require("frame_id").error().message, "a.csv:2: frame_id is 'world', a number is expected");
  EXPECT_EQ(table->require("q").error().message, "a.csv:2: q is '', a number is expected");
  EXPECT_EQ(table->require_numbers({0, 3, 1}).error().message,
            "a.csv:2: frame_id is 'world', a number is expected");
  EXPECT_EQ(table->require_within({3, 2}, 5.0).error().message, "a.csv:2: q is '', a number is expected");
}

TEST(Csv, WithoutAHeaderEveryColumnCounts) {
  const auto table = parse_csv("0,1\n1,abc\n", "a.csv");
  ASSERT_FALSE(table.has_value());
  EXPECT_EQ(table.error().message, "a.csv:2: column 2 is 'abc', a number is expected");
}

TEST(Csv, AColumnOfTextMayBeAskedFor) {
  const auto table = parse_csv("label,x_mm\nleft,1\n", "f");
  EXPECT_EQ(table->require("label"), 0u);
  EXPECT_TRUE(table->require_within({0, 1}, 2.0).has_value());
}

TEST(Csv, RefusesNanInfinityRaggedRowsEmptyAndBinaryFiles) {
  for (const char* cell : {"nan", "inf", "1e999", "+-1"}) {
    const auto table = parse_csv(std::string("a,b\n1,") + cell + "\n", "f");
    ASSERT_TRUE(table.has_value());
    EXPECT_FALSE(table->require("b").has_value()) << cell;
  }
  EXPECT_FALSE(parse_csv("a,b\n1\n", "f").has_value());
  EXPECT_FALSE(parse_csv("", "f").has_value());
  EXPECT_FALSE(parse_csv(std::string("a\0b", 3), "f").has_value());
}

TEST(Csv, KeepsLabelsAsText) {
  const auto table = parse_csv("label,x_mm\nleft,1\n", "f");
  ASSERT_TRUE(table.has_value());
  EXPECT_EQ(table->text[0][0], "left");
}

TEST(Csv, ATextCellIsANameAMessageCanQuote) {
  const auto with = [](const std::string& name) { return parse_csv("name,x\n" + name + ",1\n", "f.csv"); };
  EXPECT_EQ(with("Größe 3 (links)")->text[0][0], "Größe 3 (links)");
  EXPECT_EQ(with(std::string(120, 'a'))->text[0][0].size(), 120u);
  for (const auto& name : {std::string(121, 'a'), std::string("vi\tew"), std::string("vi\vew")}) {
    const auto table = with(name);
    ASSERT_FALSE(table.has_value());
    EXPECT_EQ(table.error().message.find("f.csv:2: name is '"), 0u) << table.error().message;
    EXPECT_NE(table.error().message.find("at most 120 bytes"), std::string::npos);
  }
}

TEST(Csv, ANameSteersNoTerminal) {
  EXPECT_FALSE(parse_csv("name,x\nle\u202Eft,1\n", "f").has_value());
  EXPECT_FALSE(parse_csv("name,x\n\u009B31mleft,1\n", "f").has_value());
  EXPECT_TRUE(parse_csv("name,x\nM\xFCller,1\n", "f").has_value());  // Latin-1
}

// A row takes some hundred bytes of memory however short it is, and a cell 56.
TEST(Csv, RefusesWhatIsLargerThanAnyTableOfMeasurements) {
  std::string rows;
  for (std::size_t i = 0; i < kMostTableRows; ++i) rows += "1\n";
  EXPECT_EQ(parse_csv(rows, "f")->rows.size(), kMostTableRows);
  const auto longer = parse_csv(rows + "1\n", "f");
  ASSERT_FALSE(longer.has_value());
  EXPECT_EQ(longer.error().message.find("f:4000001: a table of at most 4000000 rows"), 0u)
      << longer.error().message;
  const auto wider = parse_csv(std::string(200'000'000, ','), "f");
  ASSERT_FALSE(wider.has_value());
  EXPECT_NE(wider.error().message.find("more than 10000 cells"), std::string::npos) << wider.error().message;
}

TEST(Csv, NumbersTooLargeForTheirColumnAreNamed) {
  const auto table = parse_csv("t_s,x_mm\n0,1\n-1e300,5\n", "a.csv");
  ASSERT_TRUE(table.has_value());
  EXPECT_TRUE(table->require_within({1}, 5.0).has_value());
  const auto refused = table->require_within({1, 0}, 10.0);
  ASSERT_FALSE(refused.has_value());
  EXPECT_EQ(refused.error().message,
            "a.csv:3: t_s is -1e+300; at most 10 is expected, check the unit or remove the row");
}

TEST(Csv, WhatAMessageQuotesStaysOnItsLine) {
  const auto table = parse_csv("t_s,x\v\n0,\x1b[31m\n", "a.csv");
  ASSERT_FALSE(table.has_value());
  EXPECT_EQ(table.error().message, "a.csv: is not a text file; a CSV table is expected");
  // beyond the first 4096 bytes nobody looks for such characters
  const auto late = parse_csv("t_s,x\n" + std::string(5000, '#') + "\n0,\x1b[31m\n", "a.csv");
  ASSERT_TRUE(late.has_value());
  EXPECT_EQ(late->require("x").error().message, "a.csv:3: x is '?[31m', a number is expected");
}

}  // namespace
}  // namespace palpate::inline core
