// One printed page: black rectangles, lines and words at places in metres, as a PDF file.
//
// x to the right and y down from the page's upper left corner; what is drawn later covers what was drawn
// before. Vector graphics alone, in PDF 1.4 with its built-in Helvetica, the same bytes for the same page.
// Words: ASCII (others become '?'). Throws std::invalid_argument for a page that has no size. One thread.
// Source: ISO 32000-1, sections 7.5 (file) and 8.5 (paths).
#pragma once

#include <string>
#include <string_view>

namespace palpate::vision {

class PdfPage {
 public:
  PdfPage(double width, double height, std::string title);

  void rectangle(double x, double y, double width, double height, double grey = 0.0);  // filled; 0 black
  void line(double x1, double y1, double x2, double y2, double thickness);
  // `y` is the baseline, `size` the letters' em.
  void text(double x, double y, double size, std::string_view words);

  double width() const { return width_; }
  double height() const { return height_; }
  std::string bytes() const;

 private:
  std::string at(double x, double y) const;
  double width_, height_;
  std::string title_, content_;
};

}  // namespace palpate::vision
