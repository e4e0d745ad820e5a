#include "palpate/evaluation/report/format.h"

#include <gtest/gtest.h>

#include <cmath>

#include "palpate/core/file.h"
#include "tests/scratch_folder.h"

namespace palpate::evaluation::report {
namespace {

TEST(Format, ShowsNumbersWithDigitsAndUnits) {
  EXPECT_EQ(formatted(0.12345, "3 mm"), "0.123\u00a0mm");
  EXPECT_EQ(formatted(0.5, "3"), "0.5");
  EXPECT_EQ(formatted(12.0, "3 °"), "12°");
  EXPECT_EQ(formatted(0.0042, "3 %"), "0.42\u00a0%");
  EXPECT_EQ(formatted(0.0125, "+.1f %"), "+1.2\u00a0%");
  EXPECT_EQ(formatted(0.93, "3 percent"), "93");
  EXPECT_EQ(formatted(7, ".2f s"), "7.00\u00a0s");
  EXPECT_EQ(formatted(999.0, "us"), "999\u00a0\u00b5s");
  EXPECT_EQ(formatted(15161.817, "us"), "15.2\u00a0ms");
}

TEST(Format, ShowsValuesAsTheyAreAndADashForNone) {
  EXPECT_EQ(formatted(123456789, ""), "123456789");
  EXPECT_EQ(formatted(8.5, ""), "8.5");
  EXPECT_EQ(formatted(1e-9, ""), "1e-9");
  EXPECT_EQ(formatted("a < b", ""), "a < b");
  EXPECT_EQ(formatted(nullptr, ""), "\u2014");
  EXPECT_EQ(formatted(nullptr, "3 mm"), "\u2014");
  EXPECT_EQ(formatted(NAN, "3 mm"), "\u2014");
}

TEST(Format, AnswersComparisons) {
  EXPECT_EQ(formatted(0.0, "> 0"), "");
  EXPECT_EQ(formatted(0.1, "> 0"), "true");
  EXPECT_EQ(formatted(0.9, "< 1"), "true");
  EXPECT_EQ(formatted(1, "= 1"), "true");
  EXPECT_EQ(formatted(nullptr, "< 1"), "");
}

TEST(Format, EscapesProseAndTurnsBackticksIntoCode) {
  EXPECT_EQ(formatted("run `a < b` and `c", "prose"), "run <code>a &lt; b</code> and <code>c</code>");
}

TEST(Format, WhatIsNoFormatShowsAsAQuestionMark) {
  EXPECT_EQ(formatted(1.0, "> many"), "?");
  EXPECT_EQ(formatted(1.0, ".3q mm"), "?");
}

// A page shows files of its folder, and no others of the machine.
TEST(Format, CarriesFilesOfTheFolderAlone) {
  const ScratchFolder folder;
  std::filesystem::create_directories(folder / "page" / "pictures");
  ASSERT_TRUE(write_file(folder / "page" / "pictures" / "a.png", "foob"));
  ASSERT_TRUE(write_file(folder / "secret.png", "foob"));
  EXPECT_EQ(formatted("pictures/a.png", "data", folder / "page"), "data:image/png;base64,Zm9vYg==");
  EXPECT_EQ(formatted("pictures/b.png", "data", folder / "page"), "");
  EXPECT_EQ(formatted("../secret.png", "data", folder / "page"), "");
  EXPECT_EQ(formatted((folder / "secret.png").string(), "data", folder / "page"), "");
}

TEST(JsonNumbers, RoundsToATenThousandthOfTheSpan) {
  std::vector<double> values;
  for (int i = 0; i <= 100; ++i) values.push_back(12.0 + std::sin(i) * 0.37);
  const Json parsed = Json::parse(json_numbers(values));
  ASSERT_EQ(parsed.size(), values.size());
  for (std::size_t i = 0; i < values.size(); ++i) EXPECT_NEAR(parsed[i].get<double>(), values[i], 0.74e-4);
  EXPECT_LT(json_numbers(values).size(), 9 * values.size());
}

TEST(JsonNumbers, KeepsSmallNumbersOfLogarithmicAxes) {
  const Json parsed = Json::parse(json_numbers({1e-9, 3.3333e-4, 1000.0}, true));
  EXPECT_NEAR(parsed[0].get<double>(), 1e-9, 1e-13);
  EXPECT_NEAR(parsed[1].get<double>(), 3.3333e-4, 1e-7);
}

TEST(JsonNumbers, WritesGapsConstantsAndNothing) {
  EXPECT_EQ(json_numbers({1.0, NAN, INFINITY}), "[1,null,null]");
  EXPECT_EQ(json_numbers({}), "[]");
  EXPECT_EQ(json_numbers({0.0, 0.0}), "[0,0]");
  EXPECT_EQ(json_numbers({-1e-9, 1.0}), "[0,1]");
}

}  // namespace
}  // namespace palpate::evaluation::report
