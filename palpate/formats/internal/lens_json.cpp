// A lens as `palpate calibrate camera --json` writes it.
#include <cmath>

#include "palpate/core/json.h"
#include "palpate/formats/internal/forms.h"
#include "palpate/formats/internal/lens_keys.h"
#include "palpate/formats/internal/text_table.h"

namespace palpate::formats {

bool is_lens_json(std::string_view content) {
  return trimmed(content.substr(0, 4096)).starts_with('{') && content.size() <= kMostBytesOfAFew &&
         content.find("\"fx\"") != std::string_view::npos;
}

Expected<Content> read_lens_json(const Source& source) {
  const Json json = Json::parse(source.content, nullptr, false);
  Lens lens;
  const auto number = [&](const char* key, double& value) {
    if (!json.is_object() || !json.contains(key) || !json[key].is_number()) return false;
    value = json[key].get<double>();
    return std::isfinite(value);
  };
  for (const auto& [key, value] :
       {std::pair{"fx", &lens.fx}, {"fy", &lens.fy}, {"cx", &lens.cx}, {"cy", &lens.cy}})
    if (json.is_discarded() || !number(key, *value))
      return wrong_use("{}: no number '{}'; what calibrate camera --json writes is expected", source.name,
                       key);
  if (json.contains("lens") && json["lens"].is_string())
    lens.kind = device::lens_kind(json["lens"].get<std::string>()).value_or(lens.kind);
  const std::size_t count = device::coefficient_count(lens.kind);
  if (json.contains("distortion") && json["distortion"].is_array() && json["distortion"].size() == count)
    for (std::size_t i = 0; i < count; ++i)
      if (json["distortion"][i].is_number()) lens.distortion[i] = json["distortion"][i].get<double>();
  double width = 0.0, height = 0.0;
  if (number("width_px", width) && number("height_px", height) && width >= 1 && height >= 1 && width < 1e6 &&
      height < 1e6)
    lens.size = {static_cast<int>(width), static_cast<int>(height)};
  if (!(lens.fx > 0.0) || !(lens.fy > 0.0))
    return wrong_use("{}: focal lengths above 0 are expected", source.name);
  return Content{"a lens of this program", told_of(lens), lens};
}

}  // namespace palpate::formats
