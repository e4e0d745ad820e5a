#include "palpate/figures/limits.h"

#include <gtest/gtest.h>

namespace palpate::figures {
namespace {

Json judge(const char* figures, const char* limits) {
  const auto all = judged(Json::parse(figures), limits, "limits.toml");
  EXPECT_TRUE(all) << all.error().message;
  return all ? *all : Json();
}

// Exactly at its limit a figure holds, either way.
TEST(Limits, AVerdictFlipsWhereAFigureCrossesItsLimit) {
  const auto verdict = [](const char* value, const char* limit) {
    const std::string figures = fmt::format(R"({{"a": {{"b_mm": {}}}}})", value),
                      toml = fmt::format("[it]\nfigure = \"a/b_mm\"\n{}", limit);
    return judge(figures.c_str(), toml.c_str())["it"]["verdict"];
  };
  EXPECT_EQ(verdict("0.3", "at_most = 0.3"), "holds");
  EXPECT_EQ(verdict("0.3000001", "at_most = 0.3"), "falls short");
  EXPECT_EQ(verdict("990", "at_least = 990.0"), "holds");
  EXPECT_EQ(verdict("989.9", "at_least = 990.0"), "falls short");
  EXPECT_EQ(verdict("12", "unit = \"mm\""), nullptr) << "no limit, no verdict";
}

TEST(Limits, SayWhatWasJudgedInWhichUnit) {
  const Json it =
      judge(R"({"a": {"b_mm": 0.5}})", "[it]\nfigure = \"a/b_mm\"\nunit = \"mm\"\nat_most = 1")["it"];
  EXPECT_EQ(
      it,
      Json::parse(
          R"({"figure": "a/b_mm", "label": "a/b_mm", "unit": "mm", "value": 0.5, "limit": 1.0, "verdict": "holds", "bound": "at most"})"));
}

TEST(Limits, ALabelSaysInWordsWhatAFigureIs) {
  EXPECT_EQ(judge(R"({"a": 1})", "[it]\nlabel = \"How much\"\nfigure = \"a\"\nat_most = 1")["it"]["label"],
            "How much");
}

TEST(Limits, AFigureThatIsNotKnownIsLeftOutUnlessItIsNeeded) {
  const char* limits = "[it]\nfigure = \"net/back_s\"\nat_most = 1\nneeded_by = \"net\"";
  EXPECT_FALSE(judge("{}", limits).contains("it"));
  const Json never = judge(R"({"net": {"cut_s": 3}})", limits)["it"];
  EXPECT_EQ(never["verdict"], "falls short");
  EXPECT_EQ(never["value"], nullptr);
  EXPECT_EQ(judge(R"({"net": {"back_s": 0.5}})", limits)["it"]["verdict"], "holds");
}

TEST(Limits, AShareIsJudgedWhereTheWholeIsLargeEnough) {
  const auto of = [](int returned, int serves) {
    return judge(fmt::format(R"({{"returned": {}, "serves": {}}})", returned, serves).c_str(),
                 "[it]\nfigure = \"returned\"\nof = \"serves\"\nof_at_least = 20\nat_least = 0.6")["it"];
  };
  EXPECT_EQ(of(12, 20)["verdict"], "holds");
  EXPECT_EQ(of(11, 20)["verdict"], "falls short");
  EXPECT_EQ(of(11, 20)["value"], 0.55);
  EXPECT_EQ(of(1, 19)["verdict"], nullptr);
}

TEST(Limits, OtherFiguresLimitOneToo) {
  const char* limits = "[it]\nfigure = \"ours\"\nat_most = 0.3\nleast_of = [\"a\", \"b\"]\nshare = 0.5";
  EXPECT_EQ(judge(R"({"ours": 0.2, "a": 0.9, "b": 0.5})", limits)["it"]["limit"], 0.25);
  EXPECT_EQ(judge(R"({"ours": 0.2, "a": 0.9})", limits)["it"]["limit"], 0.3);
  EXPECT_EQ(judge(R"({"ours": 0.2})", limits)["it"]["limit"], nullptr) << "neither is known";
}

TEST(Limits, AMistakeInTheFileIsNamedWhateverTheFiguresAre) {
  const auto complaint = [](const char* toml) {
    const auto all = judged(Json::object(), toml, "my-limits.toml");
    return all ? std::string("none") : all.error().message;
  };
  EXPECT_NE(complaint("[it]\nat_most = 1").find("my-limits.toml:1: it.figure"), std::string::npos)
      << complaint("[it]\nat_most = 1");
  EXPECT_NE(complaint("[it]\nfigure = \"a\"\nat_mots = 1").find("at_mots"), std::string::npos);
  EXPECT_NE(complaint("[it\n").find("my-limits.toml:1"), std::string::npos);
}

}  // namespace
}  // namespace palpate::figures
