#include "palpate/vision/pdf_page.h"

#include <fmt/format.h>

#include <array>
#include <stdexcept>

namespace palpate::vision {
namespace {

constexpr double kPointsPerMetre = 72.0 / 0.0254;

// 1e-5 points are 4 nm: places are exact for every purpose.
std::string points(double metres) { return fmt::format("{:.5f}", kPointsPerMetre * metres); }

std::string pdf_text(std::string_view words) {
  std::string text = "(";
  for (const char c : words) {
    if (c == '(' || c == ')' || c == '\\') text += '\\';
    text += c >= 32 && c < 127 ? c : '?';
  }
  return text + ")";
}

}  // namespace

PdfPage::PdfPage(double width, double height, std::string title)
    : width_(width), height_(height), title_(std::move(title)) {
  if (!(width > 0.0 && width < 5.0 && height > 0.0 && height < 5.0))
    throw std::invalid_argument(fmt::format("pdf: a page of {} x {} m", width, height));
}

std::string PdfPage::at(double x, double y) const { return points(x) + " " + points(height_ - y); }

void PdfPage::rectangle(double x, double y, double width, double height, double grey) {
  content_ += fmt::format("{:.3f} g {} {} {} re f\n", grey, at(x, y + height), points(width), points(height));
}

void PdfPage::line(double x1, double y1, double x2, double y2, double thickness) {
  content_ += fmt::format("0 G {} w {} m {} l S\n", points(thickness), at(x1, y1), at(x2, y2));
}

void PdfPage::text(double x, double y, double size, std::string_view words) {
  content_ += fmt::format("BT 0 g /F1 {} Tf {} Td {} Tj ET\n", points(size), at(x, y), pdf_text(words));
}

std::string PdfPage::bytes() const {
  // PrintScaling: a reader that heeds it does not shrink the page to the printer's margins.
  const std::array<std::string, 6> objects = {
      "<< /Type /Catalog /Pages 2 0 R /ViewerPreferences << /PrintScaling /None >> >>",
      "<< /Type /Pages /Kids [3 0 R] /Count 1 >>",
      fmt::format("<< /Type /Page /Parent 2 0 R /MediaBox [0 0 {} {}] /Contents 4 0 R /Resources << /Font << "
                  "/F1 5 0 R >> >> >>",
                  points(width_), points(height_)),
      fmt::format("<< /Length {} >>\nstream\n{}endstream", content_.size(), content_),
      "<< /Type /Font /Subtype /Type1 /BaseFont /Helvetica >>",
      fmt::format("<< /Title {} /Producer (palpate) >>", pdf_text(title_))};
  std::string file = "%PDF-1.4\n";
  std::string table = fmt::format("xref\n0 {}\n0000000000 65535 f \n", objects.size() + 1);
  for (std::size_t i = 0; i < objects.size(); ++i) {
    table += fmt::format("{:010} 00000 n \n", file.size());
    file += fmt::format("{} 0 obj\n{}\nendobj\n", i + 1, objects[i]);
  }
  const auto start = file.size();
  return file + table +
         fmt::format("trailer\n<< /Size {} /Root 1 0 R /Info 6 0 R >>\nstartxref\n{}\n%%EOF\n",
                     objects.size() + 1, start);
}

}  // namespace palpate::vision
