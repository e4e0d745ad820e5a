#include "palpate/evaluation/report/page.h"

#include <gtest/gtest.h>

#include <cmath>
#include <regex>

#include "palpate/core/file.h"
#include "tests/scratch_folder.h"

namespace palpate::evaluation::report {
namespace {

const std::string kEvil = "<script>alert('x')</script>&\"";

// The page without what came from elsewhere unchanged.
std::string own_part(std::string page) {
  const std::string plotly(PageTemplates().text("plotly-cartesian.min.js"));
  if (const auto at = page.find(plotly); at != std::string::npos) page.erase(at, plotly.size());
  return page;
}

// A page of this one template.
Expected<std::string> page(std::string_view body, Json data, const std::filesystem::path& folder = {}) {
  PageTemplates templates;
  templates.add({{"mine.html", body}});
  data["kind"] = "mine";
  const auto rendered = page_of(data, templates, folder);
  if (!rendered) return tl::unexpected(rendered.error());
  return rendered->text;
}

std::vector<figures::Section> section_of_everything(const std::string& text) {
  figures::Plot plot{.title = text,
                     .x_label = text,
                     .series = {{.name = text, .x = {1, 2}, .y = {3, NAN}, .hover = {text}}},
                     .caption = text};
  plot.levels.push_back({.at = 0.3, .label = text, .upright = true});
  plot.y_range = {0, 5};
  return {{text,
           "first",
           {text, std::vector<figures::Figure>{{text, text, text, figures::Verdict::falls_short}},
            std::vector<figures::Plot>{plot}, figures::Table{{text}, {{text}, {text}}}}}};
}

TEST(Page, NamesItsSectionsAndItsTitle) {
  const auto html = page("<header><h1>A &amp; B</h1></header>{{#more}}<h2 id=\"more\">C &lt; D</h2>{{/more}}",
                         {{"more", true}});
  ASSERT_TRUE(html) << html.error().message;
  EXPECT_NE(html->find("<title>A &amp; B</title>"), std::string::npos);
  EXPECT_NE(html->find("<a href=\"#more\">C &lt; D</a>"), std::string::npos);
  EXPECT_EQ(page("<header><h1>A</h1></header>", {}).value().find("<nav"), std::string::npos);
}

TEST(Page, AnEndlessHeadingIsAHeading) {
  const std::string endless(2'000'000, 'x');
  const auto html = page("<h2 id=\"a\">{{long}}</h2>", {{"long", endless}});
  ASSERT_TRUE(html) << html.error().message;
  EXPECT_NE(html->find("<a href=\"#a\">" + endless + "</a>"), std::string::npos);
}

TEST(Page, LoadsNothingFromElsewhere) {
  const ScratchFolder folder;
  ASSERT_TRUE(write_file(folder / "a.png", "\x89PNG"));
  const auto html =
      page("<header><h1>A</h1></header>{{>sections}}<img src=\"{{picture | data}}\">",
           {{"sections", json_of(section_of_everything("words"))}, {"picture", "a.png"}}, folder.path());
  ASSERT_TRUE(html) << html.error().message;
  const std::string own = own_part(*html);
  // Whatever a browser would fetch stands in src, href, poster, url() or @import.
  static const std::regex reference(R"re((src|href|poster)="([^"]*)")re");
  int references = 0;
  for (auto at = std::sregex_iterator(own.begin(), own.end(), reference); at != std::sregex_iterator();
       ++at) {
    const std::string target = (*at)[2];
    EXPECT_TRUE(target.starts_with("data:") || target.starts_with("#")) << target;
    ++references;
  }
  EXPECT_EQ(references, 3);  // icon, contents, picture
  for (const char* loading : {"@import", "url(", "http"}) EXPECT_EQ(own.find(loading), std::string::npos);
}

TEST(Page, CarriesPlotlyOnlyWhereSomethingIsPlotted) {
  const std::string plotly(PageTemplates().text("plotly-cartesian.min.js"));
  EXPECT_NE(plotly.find("Licensed under the MIT license"), std::string::npos);
  EXPECT_LT(page("<p>Only text.</p>", {}).value().size(), 30000u);
  EXPECT_NE(page("<figure class=\"plot\"></figure>", {}).value().find(plotly), std::string::npos);
}

TEST(Page, EscapesTextFromOutside) {
  const auto html =
      page("<p title=\"{{evil}}\">{{evil}}</p>{{>sections}}<data data-x=\"{{list | json}}\"></data>",
           {{"evil", kEvil}, {"list", {kEvil}}, {"sections", json_of(section_of_everything(kEvil))}});
  ASSERT_TRUE(html) << html.error().message;
  const std::string own = own_part(*html);
  EXPECT_EQ(own.find("<script>alert"), std::string::npos);
  EXPECT_EQ(own.find("&\""), std::string::npos);
  EXPECT_NE(own.find("&lt;script&gt;alert("), std::string::npos);
}

// A section as data: what it says, what its plot holds, and what its figures were judged.
TEST(Page, DrawsSectionsThatStandAsData) {
  const auto html = page("{{>sections}}", {{"sections", json_of(section_of_everything("seen"))}});
  ASSERT_TRUE(html) << html.error().message;
  for (const char* part :
       {"<h2 id=\"first\">seen</h2>", "<p>seen</p>", "<b>falls short</b>", "<th>seen</th>",
        "data-x=\"[1,2]\"", "data-y=\"[3,null]\"", "data-yrange=\"[0.0,5.0]\"", "data-upright"})
    EXPECT_NE(html->find(part), std::string::npos) << part;
  const auto count = [&](const std::string& what) {
    int found = 0;
    for (auto at = html->find(what); at != std::string::npos; at = html->find(what, at + 1)) ++found;
    return found;
  };
  EXPECT_EQ(count("<tr>"), 3);
}

TEST(Templates, ANameThatIsNotThereIsAnErrorUnlessItIsACondition) {
  const auto wrong = page("<p>{{arm.eror}}</p>", {{"arm", {{"error", 1}}}});
  ASSERT_FALSE(wrong);
  EXPECT_EQ(wrong.error().exit_code(), 2);
  EXPECT_NE(wrong.error().message.find("mine.html names 'arm.eror'"), std::string::npos)
      << wrong.error().message;
  EXPECT_FALSE(page("{{eror | 3 mm}}", {}));
  EXPECT_NE(page("{{#missing}}x{{/missing}}{{^missing}}none{{/missing}}", {}).value().find("none"),
            std::string::npos);
  EXPECT_FALSE(page("{{#open}}", {{"open", true}}));
}

// Of several templates that make a page, the one to repair is named.
TEST(Templates, AMistakeIsToldOfTheTemplateThatHasIt) {
  const auto complaint = [](std::string_view part) {
    PageTemplates templates;
    templates.add({{"mine.html", "<p>{{>part}}</p>"}, {"part.html", part}});
    const auto rendered = page_of({{"kind", "mine"}}, templates, {});
    return rendered ? std::string("none") : rendered.error().message;
  };
  EXPECT_EQ(complaint("{{ arm.eror | 3 mm }}"),
            "part.html names 'arm.eror | 3 mm', which the report does not hold");
  EXPECT_EQ(complaint("{{>nowhere}}"), "part.html names the template nowhere.html, which is not there");
  EXPECT_TRUE(complaint("{{#open}}").starts_with("part.html: ")) << complaint("{{#open}}");
  EXPECT_EQ(complaint("{{> part}}"), "part.html takes itself in");
  EXPECT_EQ(complaint("{{#never}}{{>mine}}{{/never}}"), "mine.html takes itself in");
  EXPECT_EQ(complaint(""), "none") << "an empty file leaves a part out";
}

TEST(Templates, ConditionsTakeZeroForAValueAndEmptyTextForNone) {
  const auto shown = [](const Json& value) {
    const std::string html = page("{{#it}}<i>there</i>{{/it}}{{^it}}not{{/it}}", {{"it", value}}).value();
    return html.find("<i>there</i>") != std::string::npos;
  };
  EXPECT_TRUE(shown(0));
  EXPECT_TRUE(shown("text"));
  EXPECT_TRUE(shown(Json::object()));
  for (const Json& none : {Json(), Json(false), Json(""), Json::array()})
    EXPECT_FALSE(shown(none)) << none.dump();
}

TEST(Templates, LoopsSeeTheirItemFirst) {
  const auto html = page(
      "{{#rows}}<i>{{name}}:{{#.cells}}{{.}},{{/.cells}}{{all}}</i>{{/rows}}"
      "{{#lists}}({{#.}}{{. | .1f}} {{/.}}){{/lists}}",
      Json::parse(R"({"all": "!", "name": "outer", "rows": [{"name": "a"}, {"name": "b"}],
                                         "lists": [[1, 2], [3]]})"));
  ASSERT_TRUE(html) << html.error().message;
  EXPECT_NE(html->find("<i>a:!</i><i>b:!</i>(1.0 2.0 )(3.0 )"), std::string::npos) << *html;
}

// What a person changes: one file of a folder in the place of one inside the program.
TEST(Templates, AFolderReplacesSingleFiles) {
  const ScratchFolder folder;
  ASSERT_TRUE(write_file(folder / "cards.html", "<p>mine</p>"));
  PageTemplates templates;
  ASSERT_TRUE(templates.add_folder(folder.path()));
  EXPECT_EQ(templates.text("cards.html"), "<p>mine</p>");
  EXPECT_FALSE(templates.text("page.css").empty());
  const auto wrong = templates.add_folder(folder / "nowhere");
  ASSERT_FALSE(wrong);
  EXPECT_EQ(wrong.error().exit_code(), 2);
}

TEST(Report, IsWrittenAsJsonAndAsAPageAndRefusedWithoutAKind) {
  const ScratchFolder folder;
  PageTemplates templates;
  templates.add({{"mine.html", "<header><h1>A</h1></header><p>{{values.tip_mm | 3 mm}}</p>"}});
  ASSERT_TRUE(write_report({{"kind", "mine"}, {"values", {{"tip_mm", 0.25}}}}, templates, folder.path()));
  EXPECT_EQ(Json::parse(read_file(folder / "report.json").value())["values"]["tip_mm"], 0.25);
  EXPECT_NE(read_file(folder / "report.html").value().find("0.25\u00a0mm"), std::string::npos);
  EXPECT_FALSE(page_of(Json::array(), templates, folder.path()));
  EXPECT_FALSE(page_of({{"kind", "unheard-of"}}, templates, folder.path()));
  EXPECT_FALSE(write_report({{"kind", "mine"}}, templates, folder.path()));
  EXPECT_TRUE(Json::parse(read_file(folder / "report.json").value()).contains("values")) << "left as it was";
}

}  // namespace
}  // namespace palpate::evaluation::report
