#include "palpate/evaluation/report/report.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>

#include "palpate/core/file.h"
#include "palpate/core/json.h"
#include "palpate/evaluation/report/assets.h"
#include "palpate/evaluation/report/plot_json.h"

namespace palpate::evaluation::report {
namespace {

// Escaped text, with what stands between backticks as code.
std::string prose(std::string_view text) {
  std::string out;
  bool inside = false;
  std::size_t start = 0;
  while (true) {
    const auto tick = text.find('`', start);
    out += escaped(text.substr(start, tick - start));
    if (tick == std::string_view::npos) break;
    out += inside ? "</code>" : "<code>";
    inside = !inside;
    start = tick + 1;
  }
  if (inside) out += "</code>";
  return out;
}

// JSON inside a script element: no "<" stands in it literally, so that nothing in a text ends or nests the
// element.
std::string for_script(std::string json) {
  for (std::size_t at = 0; (at = json.find('<', at)) != std::string::npos; at += 6)
    json.replace(at, 1, "\\u003c");
  return json;
}

std::string verdict_class(figures::Verdict verdict) {
  return verdict == figures::Verdict::holds         ? " holds"
         : verdict == figures::Verdict::falls_short ? " short"
                                                    : "";
}

std::string image(std::string_view png, std::string_view caption, std::string_view style = "") {
  return fmt::format(
      "<figure class=\"picture\"{}><img alt=\"{}\" "
      "src=\"data:image/png;base64,{}\"><figcaption>{}</figcaption></figure>\n",
      style, escaped(caption), base64(png), prose(caption));
}

// Width over height as a PNG's first chunk states them; of what is no PNG, a camera's 4 : 3.
double shape_of(std::string_view png) {
  constexpr std::size_t kSizes = 16;  // signature, and the chunk's length and name
  const auto number = [&](std::size_t at) {
    std::uint32_t value = 0;
    for (std::size_t i = 0; i < 4; ++i) value = value << 8 | static_cast<unsigned char>(png[at + i]);
    return static_cast<double>(value);
  };
  if (png.size() < kSizes + 8 || png.substr(1, 3) != "PNG" || png.substr(12, 4) != "IHDR") return 4.0 / 3.0;
  const double width = number(kSizes), height = number(kSizes + 4);
  return width > 0.0 && height > 0.0 ? width / height : 4.0 / 3.0;
}

std::string flat(const figures::Plot& plot) {
  return fmt::format(
      "<figure class=\"plot\"><figcaption class=\"above\">{}</figcaption><div class=\"canvas\" "
      "style=\"height:{}px\" role=\"img\" "
      "aria-label=\"{}\"></div>"
      "<script type=\"application/json\">{}</script>{}</figure>\n",
      escaped(plot.title), plot.height_px, escaped(plot.title), for_script(plot_json(plot)),
      plot.caption.empty() ? "" : "<figcaption>" + prose(plot.caption) + "</figcaption>");
}

}  // namespace

std::string escaped(std::string_view text) {
  std::string out;
  out.reserve(text.size());
  for (char c : text) {
    switch (c) {
      case '&':
        out += "&amp;";
        break;
      case '<':
        out += "&lt;";
        break;
      case '>':
        out += "&gt;";
        break;
      case '"':
        out += "&quot;";
        break;
      case '\'':
        out += "&#39;";
        break;
      default:
        out += c;
    }
  }
  return out;
}

std::string base64(std::string_view bytes) {
  static constexpr std::string_view letters =
      "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string out;
  out.reserve((bytes.size() + 2) / 3 * 4);
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    const std::size_t left = bytes.size() - i;
    const auto byte = [&](std::size_t k) { return k < left ? static_cast<unsigned char>(bytes[i + k]) : 0u; };
    const unsigned group = byte(0) << 16 | byte(1) << 8 | byte(2);
    out += letters[group >> 18 & 63];
    out += letters[group >> 12 & 63];
    out += left > 1 ? letters[group >> 6 & 63] : '=';
    out += left > 2 ? letters[group & 63] : '=';
  }
  return out;
}

Report::Report(std::string title, std::string subtitle)
    : title_(std::move(title)), subtitle_(std::move(subtitle)) {}

void Report::section(std::string_view title, std::string_view anchor) {
  sections_.push_back({std::string(title), std::string(anchor)});
  body_ += fmt::format("<h2 id=\"{}\">{}</h2>\n", escaped(anchor), escaped(title));
}

void Report::section(const figures::Section& section) {
  struct Add {
    Report& page;
    void operator()(const std::string& text) const { page.paragraph(text); }
    void operator()(const std::vector<figures::Figure>& figures) const { page.figures(figures); }
    void operator()(const std::vector<figures::Plot>& plots) const { page.plots(plots); }
    void operator()(const figures::Table& table) const { page.table(table.header, table.rows); }
  };
  this->section(section.title, section.anchor);
  for (const auto& block : section.blocks) std::visit(Add{*this}, block);
}

void Report::paragraph(std::string_view text) { body_ += "<p>" + prose(text) + "</p>\n"; }

void Report::aside(std::string_view text) { body_ += "<p class=\"aside\">" + prose(text) + "</p>\n"; }

void Report::figures(const std::vector<figures::Figure>& figures) {
  body_ += "<div class=\"cards\">\n";
  for (const auto& figure : figures) {
    body_ += fmt::format("<div class=\"card{}\"><div class=\"label\">{}</div><div class=\"value\">{}</div>",
                         verdict_class(figure.verdict), prose(figure.label), prose(figure.value));
    if (figure.verdict != figures::Verdict::none || !figure.bar.empty()) {
      const char* said = figure.verdict == figures::Verdict::holds         ? "<b>holds</b> "
                         : figure.verdict == figures::Verdict::falls_short ? "<b>falls short</b> "
                                                                           : "";
      body_ += fmt::format("<div class=\"bar\">{}{}</div>", said, prose(figure.bar));
    }
    body_ += "</div>\n";
  }
  body_ += "</div>\n";
}

void Report::table(const std::vector<std::string>& header,
                   const std::vector<std::vector<std::string>>& rows) {
  body_ += "<div class=\"scroll\"><table><thead><tr>";
  for (const auto& cell : header) body_ += "<th>" + prose(cell) + "</th>";
  body_ += "</tr></thead><tbody>\n";
  for (const auto& row : rows) {
    body_ += "<tr>";
    for (const auto& cell : row) body_ += "<td>" + prose(cell) + "</td>";
    body_ += "</tr>\n";
  }
  body_ += "</tbody></table></div>\n";
}

void Report::plot(const figures::Plot& plot) {
  uses_plotly_ = true;
  body_ += flat(plot);
}

void Report::plots(const std::vector<figures::Plot>& side_by_side) {
  uses_plotly_ = true;
  body_ += "<div class=\"side-by-side\">\n";
  for (const auto& plot : side_by_side) body_ += flat(plot);
  body_ += "</div>\n";
}

void Report::cloud(const figures::Cloud& cloud) {
  body_ += fmt::format(
      "<figure class=\"cloud\"><figcaption class=\"above\">{}</figcaption><canvas style=\"height:{}px\" "
      "role=\"img\" aria-label=\"{}\"></canvas><script type=\"application/json\">{}</script>"
      "<figcaption>{}</figcaption></figure>\n",
      escaped(cloud.title), cloud.height_px, escaped(cloud.title), for_script(cloud_json(cloud)),
      prose(cloud.caption));
}

void Report::code(std::string_view text) { body_ += "<pre><code>" + escaped(text) + "</code></pre>\n"; }

void Report::picture(std::string_view png, std::string_view caption) { body_ += image(png, caption); }

void Report::pictures(const std::vector<std::pair<std::string, std::string>>& png_and_caption) {
  for (std::size_t i = 0; i < png_and_caption.size(); i += 2) {
    body_ += "<div class=\"picture-row\">\n";
    for (std::size_t k = i; k < std::min(i + 2, png_and_caption.size()); ++k) {
      const auto& [png, caption] = png_and_caption[k];
      body_ += image(png, caption, fmt::format(" style=\"--shape: {:.4f}\"", shape_of(png)));
    }
    body_ += "</div>\n";
  }
}

void Report::video(std::string_view mp4, std::string_view poster_png, std::string_view caption) {
  body_ += fmt::format(
      "<figure class=\"picture\"><video controls playsinline muted loop preload=\"metadata\"{} "
      "src=\"data:video/mp4;base64,{}\"></video><figcaption>{}</figcaption></figure>\n",
      poster_png.empty() ? "" : " poster=\"data:image/png;base64," + base64(poster_png) + "\"", base64(mp4),
      prose(caption));
}

std::string Report::html() const {
  std::string contents;
  for (const auto& s : sections_) {
    contents += fmt::format("<a href=\"#{}\">{}</a>\n", escaped(s.anchor), escaped(s.title));
  }
  std::string page =
      "<!doctype html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n"
      "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n"
      "<meta name=\"color-scheme\" content=\"light dark\">\n"
      "<link rel=\"icon\" href=\"data:,\">\n";
  page += "<title>" + escaped(title_) + "</title>\n<style>\n";
  page += page_css();
  page += "</style>\n</head>\n<body>\n<header>\n<h1>" + escaped(title_) + "</h1>\n";
  if (!subtitle_.empty()) page += "<p class=\"subtitle\">" + prose(subtitle_) + "</p>\n";
  page += "</header>\n";
  if (!contents.empty()) page += "<nav aria-label=\"Contents\">\n" + contents + "</nav>\n";
  page += "<main>\n" + body_ + "</main>\n";
  if (uses_plotly_) {
    page += "<script>";
    page += plotly_js();
    page += "</script>\n";
  }
  page += "<script>\n";
  page += page_js();
  page += "</script>\n</body>\n</html>\n";
  return page;
}

Expected<void> Report::write(const std::filesystem::path& path) const { return write_file(path, html()); }

}  // namespace palpate::evaluation::report
