// Builds one self-contained HTML page: text, key figures, tables, plots, pictures and video, with nothing to
// load.
//
// Blocks appear in the order of the calls. Every text is escaped; `like this` between backticks becomes code.
// The page needs no network, follows the reader's light or dark setting and reads on a phone and on paper.
// One thread.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "palpate/core/expected.h"
#include "palpate/figures/section.h"

namespace palpate::evaluation::report {

class Report {
 public:
  explicit Report(std::string title, std::string subtitle = "");

  // Starts a section; `anchor` (letters, digits, hyphens) is its address in the page and in the table of
  // contents.
  void section(std::string_view title, std::string_view anchor);
  void section(const figures::Section& section);  // with all that stands in it
  void paragraph(std::string_view text);
  void aside(std::string_view text);  // smaller: how something was measured
  void figures(const std::vector<figures::Figure>& figures);
  void table(const std::vector<std::string>& header, const std::vector<std::vector<std::string>>& rows);
  void plot(const figures::Plot& plot);
  void plots(const std::vector<figures::Plot>& side_by_side);
  void cloud(const figures::Cloud& cloud);
  void code(std::string_view text);
  // `png`, `mp4`: the files' bytes.
  void picture(std::string_view png, std::string_view caption);
  // Two in a row, as high as each other whatever their shapes.
  void pictures(const std::vector<std::pair<std::string, std::string>>& png_and_caption);
  void video(std::string_view mp4, std::string_view poster_png, std::string_view caption);

  std::string html() const;
  Expected<void> write(const std::filesystem::path& path) const;

 private:
  struct Section {
    std::string title, anchor;
  };
  std::string title_, subtitle_, body_;
  std::vector<Section> sections_;
  bool uses_plotly_ = false;
};

// Text as HTML: & < > " ' escaped.
std::string escaped(std::string_view text);
std::string base64(std::string_view bytes);

}  // namespace palpate::evaluation::report
