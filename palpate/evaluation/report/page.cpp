#include "palpate/evaluation/report/page.h"

#include "palpate/core/file.h"

namespace palpate::evaluation::report {
namespace {

// The text between two marks, taken out of `from` with them; empty where they are not there.
std::string cut_out(std::string& from, std::string_view begin, std::string_view end) {
  const auto first = from.find(begin);
  const auto last = first == std::string::npos ? first : from.find(end, first);
  if (last == std::string::npos) return "";
  const std::string inside = from.substr(first, last + end.size() - first);
  from.erase(first, inside.size());
  return inside;
}

// A link to each <h2>; their texts are escaped already.
std::string contents_of(const std::string& main) {
  constexpr std::string_view kBegin = "<h2 id=\"", kMiddle = "\">", kEnd = "</h2>";
  std::string links;
  for (auto at = main.find(kBegin); at != std::string::npos; at = main.find(kBegin, at)) {
    at += kBegin.size();
    const auto middle = main.find(kMiddle, at), end = main.find(kEnd, at);
    if (middle == std::string::npos || end == std::string::npos || middle > end) break;
    const auto text = middle + kMiddle.size();
    links +=
        fmt::format("<a href=\"#{}\">{}</a>\n", main.substr(at, middle - at), main.substr(text, end - text));
    at = end;
  }
  return links;
}

}  // namespace

Expected<Rendered> page_of(const Json& report, const PageTemplates& templates,
                           const std::filesystem::path& folder) {
  if (!report.is_object() || !report.contains("kind") || !report["kind"].is_string())
    return wrong_use("{}: is not a report", (folder / "report.json").string());
  std::vector<const Json*> data{&report};
  if (report.contains("summary")) data.insert(data.begin(), &report["summary"]);
  auto page = templates.render(report["kind"].get<std::string>(), data, folder);
  if (!page) return page;
  std::string& main = page->text;
  const std::string header = cut_out(main, "<header>", "</header>");
  std::string title = header;
  title = cut_out(title, "<h1>", "</h1>");
  const bool plots = main.find("<figure class=\"plot\"") != std::string::npos;
  const Json frame{{"title", title.size() > 9 ? title.substr(4, title.size() - 9) : "Palpate"},
                   {"header", header},
                   {"contents", contents_of(main)},
                   {"main", main},
                   {"style", templates.text("page.css")},
                   {"script", templates.text("page.js")},
                   {"plotly", plots ? templates.text("plotly-cartesian.min.js") : ""}};
  auto whole = templates.render("page", {&frame}, folder);
  if (whole) whole->found.merge(page->found);
  return whole;
}

Expected<void> write_report(const Json& report, const PageTemplates& templates,
                            const std::filesystem::path& folder) {
  const auto page = page_of(report, templates, folder);
  if (!page) return tl::unexpected(page.error());
  if (auto done = write_json(folder / "report.json", report); !done) return done;
  return write_file(folder / "report.html", page->text);
}

}  // namespace palpate::evaluation::report
