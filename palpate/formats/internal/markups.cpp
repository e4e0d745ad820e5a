// Points of 3D Slicer: .mrk.json and the older .fcsv.
//
// Either says in which of two systems its numbers are, LPS or RAS (x and y with opposite signs). Here all are LPS, as
// transforms of ITK are. Lengths are mm. Schema of .mrk.json: Slicer, markups-schema-v1.0.3.json.
#include <algorithm>
#include <cmath>
#include <set>

#include "palpate/core/json.h"
#include "palpate/core/text.h"
#include "palpate/formats/internal/forms.h"
#include "palpate/formats/internal/pose_numbers.h"
#include "palpate/formats/internal/text_table.h"

namespace palpate::formats {
namespace {

constexpr const char* kToldLps = "LPS, mm";
constexpr const char* kToldRas = "RAS, turned into LPS, mm";

// RAS to LPS and back.
Vector3 mirrored(const Vector3& p) { return {-p.x(), -p.y(), p.z()}; }

Expected<bool> is_ras(std::string_view system, const std::string& where) {
  if (system == "RAS" || system == "0") return true;
  if (system == "LPS" || system == "1") return false;
  return wrong_use("{}: the coordinate system is '{}'; LPS or RAS is expected", where, excerpt(system));
}

// The nodes of the file that hold control points. A parser of our own bounds would be one more; nesting beyond what any
// markups have is refused before.
bool nested_too_deep(std::string_view text) {
  int depth = 0;
  bool quoted = false;
  for (std::size_t i = 0; i < text.size(); ++i) {
    if (quoted && text[i] == '\\')
      ++i;
    else if (text[i] == '"')
      quoted = !quoted;
    else if (!quoted && (text[i] == '{' || text[i] == '['))
      ++depth;
    else if (!quoted && (text[i] == '}' || text[i] == ']'))
      --depth;
    if (depth > 64) return true;
  }
  return false;
}

Expected<void> take_points(const Json& node, const std::string& source, Points& points, bool& ras) {
  const auto system = node.contains("coordinateSystem") && node["coordinateSystem"].is_string()
                          ? node["coordinateSystem"].get<std::string>()
                          : std::string("LPS");
  const auto as_ras = is_ras(system, source);
  if (!as_ras) return tl::unexpected(as_ras.error());
  ras = *as_ras;
  if (node.contains("coordinateUnits") && node["coordinateUnits"] != "mm")
    return wrong_use("{}: coordinateUnits are {}; mm are expected", source,
                     excerpt(node["coordinateUnits"].dump()));
  for (const auto& point : node["controlPoints"]) {
    if (!point.is_object()) return wrong_use("{}: a control point is no object", source);
    const auto label = point.contains("label") && point["label"].is_string()
                           ? point["label"].get<std::string>()
                           : std::string();
    // Slicer keeps points that were never put anywhere.
    if (point.contains("positionStatus") && point["positionStatus"] != "defined") continue;
    const auto position = point.find("position");
    if (position == point.end() || !position->is_array() || position->size() != 3 ||
        !std::all_of(position->begin(), position->end(), [](const Json& n) { return n.is_number(); }))
      return wrong_use("{}: the position of control point '{}' is no list of three numbers", source,
                       excerpt(label));
    const Vector3 mm((*position)[0].get<double>(), (*position)[1].get<double>(),
                     (*position)[2].get<double>());
    auto place = place_of(1e-3 * (ras ? mirrored(mm) : mm), fmt::format("{}: '{}'", source, excerpt(label)));
    if (!place) return tl::unexpected(place.error());
    points.places.push_back(*place);
    points.labels.push_back(label);
  }
  return {};
}

// The position of a column in "# columns = id,x,y,z,..."; where the header has none, that of Slicer's own order.
struct FiducialColumns {
  std::size_t x = 1, y = 2, z = 3, label = 11;
};
FiducialColumns columns_of(std::string_view list) {
  FiducialColumns columns;
  const auto names = cells_of(list, ',', 100);
  const auto at = [&](std::string_view name, std::size_t otherwise) {
    const auto found = std::find(names.begin(), names.end(), name);
    return found == names.end() ? otherwise : static_cast<std::size_t>(found - names.begin());
  };
  columns.x = at("x", at("r", at("l", columns.x)));
  columns.y = at("y", at("a", at("p", columns.y)));
  columns.z = at("z", at("s", columns.z));
  columns.label = at("label", columns.label);
  return columns;
}

// What stands behind '=' in a comment of the header, without the commas that spreadsheets add.
std::string_view said_in(std::string_view line) {
  auto value = trimmed(line.substr(line.find('=') + 1));
  while (value.ends_with(',')) value = trimmed(value.substr(0, value.size() - 1));
  return value;
}

}  // namespace

bool is_markups(std::string_view content) {
  return trimmed(content.substr(0, 4096)).starts_with('{') &&
         content.find("\"markups\"") != std::string_view::npos;
}

Expected<Content> read_markups(const Source& source) {
  const std::string form = "markups of 3D Slicer (.mrk.json)";
  if (source.content.size() > 16 * kMostBytesOfAFew || nested_too_deep(source.content))
    return wrong_use("{}: is too large, or nested too deep, for {}", source.name, form);
  const Json json = Json::parse(source.content, nullptr, false);
  if (json.is_discarded() || !json.is_object() || !json.contains("markups") || !json["markups"].is_array())
    return wrong_use("{}: looks like {} and is no sound JSON with a list 'markups'", source.name, form);
  Points points;
  bool ras = false;
  std::size_t nodes = 0;
  for (const auto& node : json["markups"]) {
    if (!node.is_object() || !node.contains("controlPoints") || !node["controlPoints"].is_array()) continue;
    if (++nodes > 1)
      return wrong_use("{}: holds several lists of points; {} with one of them are expected", source.name,
                       form);
    if (auto taken = take_points(node, source.name, points, ras); !taken)
      return tl::unexpected(taken.error());
  }
  if (points.places.empty()) return wrong_use("{}: {} without a point that was placed", source.name, form);
  return Content{form, ras ? kToldRas : kToldLps, points};
}

bool is_fiducials(std::string_view content) {
  const auto head = content.substr(0, 400);
  return content.starts_with('#') &&
         (head.find("Markups fiducial file") != std::string_view::npos ||
          head.find("Fiducial List file") != std::string_view::npos ||  // of Slicer 3
          head.find("# CoordinateSystem") != std::string_view::npos);
}

Expected<Content> read_fiducials(const Source& source) {
  const std::string form = "markups of 3D Slicer (.fcsv)";
  Points points;
  FiducialColumns columns;
  bool ras = true;  // files before 4.11 that say nothing
  std::string_view content = source.content;
  int number = 0;
  while (const auto raw = next_line(content)) {
    ++number;
    const auto where = fmt::format("{}:{}", source.name, number);
    const auto line = trimmed(*raw);
    if (line.empty()) continue;
    if (line.front() == '#') {
      if (line.find("CoordinateSystem") != std::string_view::npos) {
        const auto said = is_ras(said_in(line), where);
        if (!said) return tl::unexpected(said.error());
        ras = *said;
      } else if (line.find("columns") != std::string_view::npos) {
        columns = columns_of(said_in(line));
      }
      continue;
    }
    const auto cells = cells_of(line, ',', 100);
    const std::size_t last = std::max({columns.x, columns.y, columns.z});
    std::array<std::optional<double>, 3> mm;
    if (cells.size() > last)
      mm = {number_of(cells[columns.x]), number_of(cells[columns.y]), number_of(cells[columns.z])};
    if (!mm[0] || !mm[1] || !mm[2])
      return wrong_use("{}: no x, y, z in the columns that the header of {} names", where, form);
    const Vector3 at(*mm[0], *mm[1], *mm[2]);
    auto place = place_of(1e-3 * (ras ? mirrored(at) : at), where);
    if (!place) return tl::unexpected(place.error());
    points.places.push_back(*place);
    points.labels.emplace_back(cells.size() > columns.label ? cells[columns.label] : std::string_view());
  }
  if (points.places.empty()) return wrong_use("{}: {} without a point", source.name, form);
  return Content{form, ras ? kToldRas : kToldLps, points};
}

}  // namespace palpate::formats
