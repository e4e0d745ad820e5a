// XML: OpenCV's FileStorage. The only place that knows tinyxml2, which expands no entities of a file's own.
#include <tinyxml2.h>

#include <cmath>
#include <limits>

#include "palpate/core/text.h"
#include "palpate/formats/internal/forms.h"
#include "palpate/formats/internal/lens_keys.h"
#include "palpate/formats/internal/text_table.h"

namespace palpate::formats {
namespace {

std::optional<std::vector<double>> numbers_in(const tinyxml2::XMLElement* element) {
  if (element == nullptr) return std::nullopt;
  const auto* data = element->FirstChildElement("data");
  const char* text = (data != nullptr ? data : element)->GetText();
  const std::vector nothing{std::numeric_limits<double>::quiet_NaN()};
  if (text == nullptr) return nothing;
  std::string on_one_line(text);
  for (char& c : on_one_line)
    if (c == '\n' || c == '\r') c = ' ';
  std::vector<double> numbers;
  for (const auto cell : cells_of(on_one_line, ' ', 10'000)) {
    const auto number = number_of(cell);
    if (!number) return nothing;
    numbers.push_back(*number);
  }
  return numbers.empty() ? nothing : numbers;
}

}  // namespace

bool is_xml(std::string_view content) { return trimmed(content.substr(0, 4096)).starts_with('<'); }

Expected<Content> read_xml(const Source& source) {
  if (source.content.size() > kMostBytesOfAFew)
    return wrong_use("{}: is XML of more than {} bytes; a lens is expected", source.name, kMostBytesOfAFew);
  tinyxml2::XMLDocument document;
  if (document.Parse(source.content.data(), source.content.size()) != tinyxml2::XML_SUCCESS)
    return wrong_use("{}:{}: is no sound XML", source.name, document.ErrorLineNum());
  const auto* root = document.FirstChildElement("opencv_storage");
  const NumbersAt numbers_at = [root](const std::string& key) {
    return root == nullptr ? std::nullopt : numbers_in(root->FirstChildElement(key.c_str()));
  };
  if (!has_lens(numbers_at) && !numbers_at("M2"))
    return wrong_use(
        "{}: is XML or a web page of a kind that is not known here; a lens of OpenCV (opencv_storage) is "
        "expected",
        source.name);
  const auto mark = numbers_at("fisheye_model");
  const bool fisheye = mark && mark->size() == 1 && std::abs(mark->front()) > 0.0;
  const auto chosen = one_camera(numbers_at, source.options.tool, source.name);
  if (!chosen) return tl::unexpected(chosen.error());
  const auto lens = lens_of(*chosen, fisheye ? "fisheye" : "", source.name);
  if (!lens) return tl::unexpected(lens.error());
  return Content{"a lens of OpenCV (XML)", told_of(*lens), *lens};
}

}  // namespace palpate::formats
