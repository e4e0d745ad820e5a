#include "palpate/evaluation/report/report.h"

#include <gtest/gtest.h>

#include <cmath>
#include <regex>

#include "palpate/core/json.h"
#include "palpate/evaluation/report/assets.h"
#include "palpate/evaluation/report/plot_json.h"

namespace palpate::evaluation::report {
namespace {

// The page without what came from elsewhere unchanged.
std::string own_part(std::string page) {
  const auto at = page.find(plotly_js());
  if (at != std::string::npos) page.erase(at, plotly_js().size());
  return page;
}

Report page_of_everything() {
  Report page("Title", "Subtitle");
  page.section("First", "first");
  page.paragraph("Text with `code`.");
  page.aside("Small print.");
  page.figures({{"Error", "0.1 mm", "at most 0.3 mm", figures::Verdict::holds},
                {"Late", "7", "at most 2", figures::Verdict::falls_short}});
  page.table({"a", "b"}, {{"1", "2"}});
  page.plot({.title = "Line", .series = {{.name = "s", .x = {0, 1}, .y = {2, 3}}}});
  page.cloud({.title = "Cloud", .unit = "mm", .groups = {{.name = "g", .points = {{0, 0, 0}, {1, 2, 3}}}}});
  page.code("x < y");
  page.picture("\x89PNG", "A picture");
  page.video("mp4", "\x89PNG", "A video");
  return page;
}

TEST(Report, LoadsNothingFromElsewhere) {
  const std::string page = own_part(page_of_everything().html());
  // Whatever a browser would fetch stands in src, href, poster, url() or @import.
  static const std::regex reference(R"re((src|href|poster)="([^"]*)")re");
  int references = 0;
  for (auto at = std::sregex_iterator(page.begin(), page.end(), reference); at != std::sregex_iterator();
       ++at) {
    const std::string target = (*at)[2];
    EXPECT_TRUE(target.starts_with("data:") || target.starts_with("#")) << target;
    ++references;
  }
  EXPECT_EQ(references, 5);  // icon, contents, picture, video, poster
  EXPECT_EQ(page.find("@import"), std::string::npos);
  EXPECT_EQ(page.find("url("), std::string::npos);
  EXPECT_EQ(page.find("http"), std::string::npos);
}

TEST(Report, CarriesPlotlyOnlyWhereSomethingIsPlotted) {
  Report page("Title");
  page.paragraph("Only text.");
  EXPECT_LT(page.html().size(), 30000u);
  page.plot({.title = "p"});
  EXPECT_NE(page.html().find(plotly_js()), std::string::npos);
}

TEST(Report, KeepsTheLicenceNoticeOfWhatItEmbeds) {
  EXPECT_NE(plotly_js().find("Licensed under the MIT license"), std::string::npos);
}

TEST(Report, EscapesEveryText) {
  const std::string evil = "<script>alert('x')</script>&\"";
  Report page(evil, evil);
  page.section(evil, "a\"b");
  page.paragraph(evil);
  page.aside(evil);
  page.figures({{evil, evil, evil, figures::Verdict::holds}});
  page.table({evil}, {{evil}});
  page.plot({.title = evil,
             .x_label = evil,
             .series = {{.name = evil, .x = {1}, .y = {1}, .hover = {evil}}},
             .caption = evil});
  page.cloud(
      {.title = evil, .unit = evil, .groups = {{.name = evil, .points = {{0, 0, 0}}}}, .caption = evil});
  page.code(evil);
  page.picture("", evil);
  page.video("", "", evil);
  const std::string html = own_part(page.html());
  EXPECT_EQ(html.find("<script>alert"), std::string::npos);
  EXPECT_EQ(html.find("'x')</script>"), std::string::npos);
  EXPECT_NE(html.find("&lt;script&gt;alert(&#39;x&#39;)"), std::string::npos);
}

// A section as data reads on the page as the same calls one by one.
TEST(Report, DrawsASectionThatIsGivenAsData) {
  const std::vector<figures::Figure> figures{{"Error", "0.1 mm", "at most 0.3 mm", figures::Verdict::holds}};
  const std::vector<figures::Plot> plots{
      {.title = "path", .series = {{.name = "s", .x = {1, 2}, .y = {3, 4}}}}};
  const figures::Table table{{"file", "rows"}, {{"a.csv", "7"}}};
  Report as_data("t"), by_calls("t");
  as_data.section({"What was felt", "felt", {"In words.", figures, table, plots}});
  by_calls.section("What was felt", "felt");
  by_calls.paragraph("In words.");
  by_calls.figures(figures);
  by_calls.table(table.header, table.rows);
  by_calls.plots(plots);
  EXPECT_NE(as_data.html().find("What was felt"), std::string::npos);
  EXPECT_EQ(as_data.html(), by_calls.html());
}

TEST(Report, TurnsBackticksIntoCodeAndClosesThem) {
  Report page("t");
  page.paragraph("run `a < b` and `c");
  EXPECT_NE(page.html().find("<p>run <code>a &lt; b</code> and <code>c</code></p>"), std::string::npos);
}

TEST(Report, SaysVerdictsInWordsNotOnlyInColour) {
  const std::string html = page_of_everything().html();
  EXPECT_NE(html.find("<b>holds</b> at most 0.3 mm"), std::string::npos);
  EXPECT_NE(html.find("<b>falls short</b> at most 2"), std::string::npos);
}

TEST(Base64, MatchesTheExamplesOfRfc4648) {
  EXPECT_EQ(base64(""), "");
  EXPECT_EQ(base64("f"), "Zg==");
  EXPECT_EQ(base64("fo"), "Zm8=");
  EXPECT_EQ(base64("foo"), "Zm9v");
  EXPECT_EQ(base64("foobar"), "Zm9vYmFy");
  EXPECT_EQ(base64("\xff\xfe\xfd"), "//79");
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

TEST(PlotJson, IsJsonWithEverythingInIt) {
  figures::Plot plot{
      .title = "a \"b\"",
      .series = {
          {.name = "s", .x = {1, 2}, .y = {3, NAN}, .mark = figures::Mark::bars, .labels = {"p", "q"}}}};
  plot.levels.push_back({.at = 0.3, .label = "bar", .upright = true});
  plot.levels.push_back({.at = 1.0, .label = "band", .to = 2.0});
  plot.y_range = {0, 5};
  const Json parsed = Json::parse(plot_json(plot));
  EXPECT_EQ(parsed["title"], "a \"b\"");
  EXPECT_EQ(parsed["series"][0]["x"], (Json{"p", "q"}));
  EXPECT_TRUE(parsed["series"][0]["y"][1].is_null());
  EXPECT_EQ(parsed["levels"][0]["at"], 0.3);
  EXPECT_EQ(parsed["levels"][0]["to"], 0.3);
  EXPECT_EQ(parsed["levels"][1]["to"], 2.0);
  EXPECT_EQ(parsed["yrange"], (Json{0, 5}));
}

}  // namespace
}  // namespace palpate::evaluation::report
